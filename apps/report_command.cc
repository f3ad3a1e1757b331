#include "apps/report_command.h"

#include <fmt/format.h>

#include <memory>

#include "apps/options.h"
#include "apps/output.h"
#include "protocol/eval/results/result_set.h"
#include "protocol/eval/results/result_tables.h"
#include "protocol/io/files.h"

namespace engram::apps {
namespace {

struct ReportOptions {
  std::string results;
  TableFormat format = TableFormat::kMarkdown;
  std::string out;
};

}  // namespace

void add_report_command(const Command& program) {
  const auto options = std::make_shared<ReportOptions>();
  const Command command = program.add_command(
      "report", "A table of the results of `engram eval`, for papers and pages");
  command.add_option("results", options->results, "Folder of a run, or a JSON file of its results")
      .required()
      .type_name("RESULTS");
  command
      .add_option(
          "--format",
          [options](const std::string& name) {
            options->format = require_option<TableFormat>("--format", name);
          },
          "Markdown, LaTeX (booktabs), CSV of tasks or of episodes, or an entry of vla-eval's "
          "leaderboard")
      .type_name("md|latex|csv|episodes|vla-eval")
      .default_str(name_of(options->format));
  command.add_option("--out", options->out, "File to write instead of standard output")
      .type_name("FILE");
  command.on_run([options] {
    const std::string table = result_table(options->format, read_results(options->results).tasks);
    options->out.empty() ? print(table) : write_output(options->out, table);
  });
}

}  // namespace engram::apps
