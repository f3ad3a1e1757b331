#include "protocol/eval/probe/probe_report.h"

#include <vector>

#include "protocol/eval/results/success_rates.h"
#include "protocol/io/decimal.h"
#include "protocol/io/files.h"
#include "protocol/io/html.h"
#include "protocol/make/make.h"
#include "protocol/make/physics_keys.h"

namespace engram {
namespace {

bool is_skipped(const Json& section) { return find(section, "skipped") != nullptr; }

std::string rounded(const Json& value) {
  return is_null(value) ? std::string("-") : decimal(number(value), 3);
}

std::string presents_text(const Json& presents) {
  if (is_null(presents)) return "-";
  return decimal(number(part(presents, "equal")), 0) + " of " +
         decimal(number(part(presents, "compared")), 0);
}

HtmlReport::CurvePoint curve_point(double x, const Json& share) {
  const JsonList& interval = list(part(share, "interval"));
  return {x, number(part(share, "rate")), number(interval.at(0)), number(interval.at(1))};
}

// The curve of a share over a quantity, of points that have both.
HtmlReport::Curve curve_of(const std::string& name, const JsonList& points, const char* x,
                           const char* share) {
  HtmlReport::Curve curve{name, {}};
  for (const Json& point : points) {
    const Json* found = find(point, share);
    if (found == nullptr || is_null(part(*found, "rate"))) continue;
    curve.points.push_back(curve_point(number(part(point, x)), *found));
  }
  return curve;
}

// The sections of a probe that were not skipped, by task.
template <class Each>
void each_task(const Json& document, const char* probe, Each&& each) {
  for (const Json& task : list(part(document, "tasks"))) {
    const Json* section = find(task, probe);
    if (section != nullptr && !is_skipped(*section)) each(text(part(task, "env_id")), *section);
  }
}

bool has_any(const Json& document, const char* probe) {
  bool any = false;
  each_task(document, probe, [&any](const std::string&, const Json&) { any = true; });
  return any;
}

void add_twins(const Json& document, HtmlReport& report) {
  if (!has_any(document, "twins")) return;
  report.heading("Twins");
  report.paragraph(
      "Two episodes have one seed, and what the policy sees at the question is the same to the "
      "bit; "
      "only what they showed before differs. Follow: the share of first answers that are right by "
      "the policy's own past; wiped: the same when the policy is reset at the question, so that "
      "only guessing is left. Swapped: the policy has seen the one cue and acts in the other's "
      "scene: it answers by its past, or by what the scene hides. Stay: the share of answers that "
      "do not change when an irrelevant part of the past does. Intervals are 95 %.");
  std::vector<std::vector<std::string>> rows;
  each_task(document, "twins", [&rows](const std::string& id, const Json& twins) {
    const Json& swapped = part(twins, "swapped");
    rows.push_back({id, decimal(number(part(twins, "pairs")), 0),
                    presents_text(part(twins, "presents")), rounded(part(twins, "chance")),
                    share_text(part(twins, "follow")), share_text(part(twins, "wiped_follow")),
                    share_text(part(swapped, "past")), share_text(part(swapped, "scene")),
                    share_text(part(twins, "stay")),
                    is_null(part(twins, "stay_by")) ? "-" : text(part(twins, "stay_by")),
                    presents_text(part(twins, "stay_presents"))});
  });
  report.table({"task", "pairs", "equal presents", "chance", "follow", "wiped", "swapped: past",
                "swapped: scene", "stay", "stay: by another", "equal presents of stay"},
               rows);
}

void add_forgetting(const Json& document, HtmlReport& report) {
  if (!has_any(document, "forgetting")) return;
  report.heading("Forgetting");
  report.paragraph(
      "Success and first answers over the control steps between cue and question; the red line is "
      "the share of right first answers of guessing. Half length: the delay at which half of what "
      "the first answers are above it is left.");
  each_task(document, "forgetting", [&report](const std::string& id, const Json& section) {
    const JsonList& points = list(part(section, "points"));
    const Json& constant = part(section, "constant");
    const Json& half = part(section, "half_length");
    const std::string axis =
        is_null(constant) ? "steps that the robot is held" : text(constant) + ", control steps";
    report.paragraph(id + ": " +
                     (is_null(half) ? std::string("never above chance")
                      : is_null(part(half, "steps"))
                          ? std::string("no half length within the longest delay")
                          : "half length " + decimal(number(part(half, "steps")), 1) + " steps"));
    report.curves({curve_of("first answer", points, "delay", "first_answer"),
                   curve_of("success", points, "delay", "success")},
                  {axis, true, number(part(section, "answer_chance"))});
  });
}

void add_interference(const Json& document, HtmlReport& report) {
  if (!has_any(document, "interference")) return;
  report.heading("Interference");
  report.paragraph(
      "First answers over the number of other episodes that the policy plays between cue and "
      "question without being reset. Competing ones show another cue, agreeing ones the same. "
      "Intrusions: the share of wrong answers that are the answer of the last other episode. The "
      "probe is fair for policies whose memory lasts until they are told of a new episode; one "
      "that "
      "remembers a fixed number of steps cannot keep a cue across episodes.");
  std::vector<std::vector<std::string>> rows;
  each_task(document, "interference", [&](const std::string& id, const Json& section) {
    std::vector<HtmlReport::Curve> curves;
    const JsonList& points = list(part(section, "points"));
    for (const Json& point : points) {
      rows.push_back({id, text(part(point, "kind")), decimal(number(part(point, "others")), 0),
                      share_text(part(point, "first_answer")), share_text(part(point, "success")),
                      share_text(part(point, "intrusions"))});
    }
    for (const char* kind : {"competing", "agreeing", "other task"}) {
      JsonList own;
      for (const Json& point : points) {
        const std::string& its = text(part(point, "kind"));
        if (its == kind || its == "none") own.push_back(point);
      }
      if (own.size() > 1) curves.push_back(curve_of(kind, own, "others", "first_answer"));
    }
    report.paragraph(id);
    report.curves(curves, {"other episodes", false, number(part(section, "answer_chance"))});
  });
  report.table({"task", "cues", "others", "first answer", "success", "intrusions"}, rows);
}

void add_capacity(const Json& document, HtmlReport& report) {
  if (!has_any(document, "capacity")) return;
  report.heading("Capacity");
  report.paragraph(
      "Success over how much there is to remember. The oracle plays the same episodes: what it "
      "does not reach is motor difficulty, not memory. Of oracle: the part of the oracle's first "
      "answers above chance that is reached.");
  std::vector<std::vector<std::string>> rows;
  each_task(document, "capacity", [&](const std::string& id, const Json& section) {
    const JsonList& points = list(part(section, "points"));
    JsonList oracle;
    for (const Json& point : points) {
      if (is_skipped(point)) continue;
      oracle.emplace_back(JsonTable{{"items", part(point, "items")},
                                    {"success", part(part(point, "oracle"), "success")}});
      rows.push_back({id, decimal(number(part(point, "items")), 0),
                      share_text(part(point, "success")), share_text(part(point, "first_answer")),
                      rounded(part(point, "answer_chance")),
                      share_text(part(part(point, "oracle"), "success")),
                      rounded(part(point, "first_answer_of_oracle"))});
    }
    report.paragraph(id);
    report.curves({curve_of("success", points, "items", "success"),
                   curve_of("first answer", points, "items", "first_answer"),
                   curve_of("oracle's success", oracle, "items", "success")},
                  {text(part(section, "quantity"))});
  });
  report.table(
      {"task", "items", "success", "first answer", "its chance", "oracle's success", "of oracle"},
      rows);
}

void add_skipped(const Json& document, HtmlReport& report) {
  std::vector<std::vector<std::string>> rows;
  for (const Json& task : list(part(document, "tasks"))) {
    for (const auto& [key, section] : table(task)) {
      if (const Json* reason = find(section, "skipped")) {
        rows.push_back({text(part(task, "env_id")), key, text(*reason)});
      }
    }
  }
  if (rows.empty()) return;
  report.heading("Not probed");
  report.table({"task", "probe", "reason"}, rows);
}

}  // namespace

std::string share_text(const Json& share) {
  if (is_null(share) || is_null(part(share, "rate"))) return "-";
  const JsonList& interval = list(part(share, "interval"));
  return rounded(part(share, "rate")) + " [" + rounded(interval.at(0)) + ", " +
         rounded(interval.at(1)) + "]";
}

std::string probe_report(const Json& document) {
  const Json& settings = part(document, "settings");
  const std::size_t tasks = list(part(document, "tasks")).size();
  HtmlReport report("Probes of memory: " + text(part(settings, "policy")) + ", " +
                    counted(tasks, "task"));
  report.table({"", ""},
               {{"policy", text(part(settings, "policy"))},
                {"observations", text(part(settings, "obs_mode"))},
                {"control mode", text(part(settings, "control_mode"))},
                {"rules", text(part(settings, "rules"))},
                {kPhysicsKey, physics_text(settings)},
                {"episodes", decimal(number(part(settings, "n_episodes")), 0)},
                {"first seed", std::to_string(whole_number(part(settings, "start_seed")))},
                {"engram", version()}});
  add_twins(document, report);
  add_forgetting(document, report);
  add_interference(document, report);
  add_capacity(document, report);
  add_skipped(document, report);
  return report.text();
}

void write_probes(const Json& document, const std::filesystem::path& folder) {
  require_writable_folder(folder);
  write_file(folder / "probe.json", to_text(document));
  write_file(folder / "probe.html", probe_report(document));
}

}  // namespace engram
