#include "apps/compare_command.h"

#include <fmt/format.h>

#include <memory>
#include <set>

#include "apps/options.h"
#include "apps/output.h"
#include "protocol/eval/results/comparison.h"
#include "protocol/eval/results/success_rates.h"
#include "protocol/make/physics_keys.h"

namespace engram::apps {
namespace {

struct CompareOptions {
  std::string a;
  std::string b;
  std::set<AllowedDifference> allowed;
  bool json = false;
};

// --- text ---

std::string rate(const Json& row, const char* key) {
  return fmt::format("{:.3f}", number(part(row, key)));
}

std::string probability(const Json& row, const char* key) {
  const Json* value = find(row, key);
  if (value == nullptr) return "";
  const double p = number(*value);
  return p < 0.0001 ? fmt::format("{:.1e}", p) : fmt::format("{:.4f}", p);
}

std::string interval(const Json& row) {
  const JsonList& bounds = list(part(row, "difference_interval"));
  return fmt::format("{:+.3f} to {:+.3f}", number(bounds.at(0)), number(bounds.at(1)));
}

std::string count(const Json& row, const char* key) {
  return std::to_string(whole_number(part(row, key)));
}

void add_row(const std::string& name, const Json& row, Table& table) {
  table.add({name, count(row, "pairs"), rate(row, "sr_a"), rate(row, "sr_b"),
             fmt::format("{:+.3f}", number(part(row, "difference"))), interval(row),
             count(row, "only_a"), count(row, "only_b"), probability(row, "p_value"),
             probability(row, "p_value_holm")});
}

std::string resolution_text(const Json& total) {
  const auto share = [&total](const char* key) {
    const Json& value = part(total, key);
    return is_null(value) ? std::string("none") : fmt::format("{:.3f}", number(value));
  };
  std::string text = fmt::format("smallest difference that can be significant with {} pairs: {}",
                                 count(total, "pairs"), share("smallest_difference"));
  if (!is_null(part(total, "detectable_difference"))) {
    text += fmt::format("; one that is found in 80 % of comparisons: {}",
                        share("detectable_difference"));
  }
  return text + "\n";
}

std::string source_text(const char* name, const Json& source) {
  std::string line = fmt::format("{}: {} in {} ({}, rules {}", name, text(part(source, "model")),
                                 text(part(source, "source")), text(part(source, "obs_mode")),
                                 text(part(source, "rules")));
  const std::string latency = count(source, "latency_steps");
  if (latency != "0") line += ", latency " + latency;
  const std::string& physics = text(part(source, kPhysicsKey));
  if (physics != name_of(Physics::kEngram)) line += ", physics " + physics;
  return line + ")\n";
}

std::string to_plain_text(const Json& comparison) {
  Table rows({{"task"},
              {"pairs", true},
              {"A", true},
              {"B", true},
              {"A - B", true},
              {"95 % interval", true},
              {"only A", true},
              {"only B", true},
              {"p", true},
              {"p (Holm)", true}});
  for (const Json& task : list(part(comparison, "tasks"))) {
    add_row(text(part(task, "env_id")), task, rows);
  }
  const JsonTable& splits = table(part(comparison, "splits"));
  for (const auto& [split, group] : splits) add_row("split " + split, group, rows);
  const Json& total = part(comparison, "total");
  add_row("total", total, rows);
  return source_text("A", part(comparison, "a")) + source_text("B", part(comparison, "b")) +
         rows.text() + "p: " + text(part(total, "test")) + ", two-sided\n" +
         resolution_text(total) + alike_text(total);
}

}  // namespace

std::string alike_text(const Json& total) {
  const Json& same = part(total, "same_digests");
  if (is_null(same)) return "digests: not in both results\n";
  const std::string pairs = count(total, "pairs");
  return fmt::format(
      "alike of {} episodes: first observations {}, first answers {}, all observations {}, all "
      "answers {}\n",
      pairs, count(same, "first_observations"), count(same, "first_answers"),
      count(same, "observations"), count(same, "answers"));
}

void add_compare_command(const Command& program) {
  const auto options = std::make_shared<CompareOptions>();
  const Command command =
      program.add_command("compare", "Compares two results of `engram eval` episode by episode");
  command.add_option("A", options->a, "Folder of a run, or a JSON file of its results")
      .required()
      .type_name("RESULTS");
  command.add_option("B", options->b, "The other one").required().type_name("RESULTS");
  command
      .add_repeatable(
          "--allow",
          [options](const std::string& name) {
            options->allowed.insert(require_option<AllowedDifference>("--allow", name));
          },
          "Compares results that differ in ids, seeds (what both have is compared), version, "
          "rules, "
          "constants (perturbations and task options, too), choices or physics (repeatable)")
      .type_name("WHAT");
  add_json(command, options->json);
  command.footer(
      "Episodes pair by id and seed. p is that of McNemar's exact test; p (Holm) is corrected for "
      "the number of tasks. The interval is Newcombe's for paired data. docs/evaluation.md has the "
      "JSON keys.");
  command.on_run([options] {
    const Json comparison =
        compare_results(read_results(options->a), read_results(options->b), options->allowed);
    print(options->json ? to_text(comparison) : to_plain_text(comparison));
  });
}

}  // namespace engram::apps
