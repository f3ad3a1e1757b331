#include "apps/merge_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/collect_command.h"
#include "apps/eval_command.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/probe_command.h"
#include "apps/run_control.h"
#include "protocol/datasets/collection.h"
#include "protocol/datasets/plan_document.h"
#include "protocol/eval/merged_evaluation.h"
#include "protocol/eval/probe/probe_report.h"
#include "protocol/io/folder_lock.h"
#include "protocol/io/html.h"
#include "protocol/parallel/shard_set.h"

namespace engram::apps {
namespace {

namespace fs = std::filesystem;

struct MergeOptions {
  std::vector<std::string> folders;
  std::string out;
  bool json = false;
};

void merge_evaluation(const ShardSet& shards, const fs::path& out, bool json) {
  const EvaluationRun run = engram::merge_evaluation(shards, out, words_of_command());
  print_results(run, json);
  if (run.settings().commitment) {
    print_warning("the results are sealed; with --seed-file, " +
                  shell_line({"engram", "eval", "--resume", run.folder()->path().string()}) +
                  " opens them");
  }
}

void merge_probes(const ShardSet& shards, const fs::path& out, bool json) {
  const Json& settled = shards.header().run;
  EvaluationSettings settings = EvaluationSettings::of(
      part(settled, "settings"), shards.parts().front().folder / kJournalFile);
  const ProbeOptions probe = probes_of(settled);
  Protocol protocol = protocol_of(settings);
  protocol.threads = 1;
  // Never asked: all episodes are known.
  if (!is_null(settings.policy_config)) {
    protocol.external = [](const WorkContext&) { return std::unique_ptr<ExternalPolicy>(); };
  }
  ProbeRun run(std::move(settings), std::move(protocol), probe);
  require_writable_folder(out);
  const FolderLock lock(out);
  Journal journal(lock.folder(), run.header({.command = words_of_command()}).document());
  for (const ShardSet::Part& shard : shards.parts()) journal.add(shard.records);
  Ranks alone;
  const Json document = run.play(alone, {}, {.journal = &journal});
  write_probes(document, out);
  journal.remove();
  print_probes(document, probe.probes, json);
}

// Plays nothing. Where attempts have failed, further ones are needed than those of the shards.
void merge_collection(const ShardSet& shards, const fs::path& out, bool json) {
  const PlannedTasks planned =
      planned_tasks(shards.header().run, shards.parts().front().folder / kJournalFile);
  std::vector<std::unique_ptr<DemonstrationFolder>> folders;
  for (const RegistryEntry* task : planned.tasks) {
    DemonstrationFolder& folder =
        *folders.emplace_back(std::make_unique<DemonstrationFolder>(out, *task, planned.plan));
    for (const ShardSet::Part& part : shards.parts()) {
      const OpenFolder own(shard_task_folder(part.folder, *task));
      folder.accept(FinishedEpisodes(own, part.records, task->id));
    }
  }
  const bool complete =
      std::ranges::all_of(folders, [](const auto& folder) { return folder->complete(); });
  if (!complete) {
    print_warning("attempts of the shards have failed; " +
                  shards.header().command_of_whole(out.string()) + " plays those that are missing");
  }
  report_collection(folders, {.plan = planned.plan, .out = out}, {}, json);
}

// Lines that a shell runs, or a program such as GNU parallel.
[[noreturn]] void refuse_missing(const std::vector<MissingShard>& missing, bool json) {
  JsonList documents;
  std::string lines;
  for (const MissingShard& one : missing) {
    documents.emplace_back(JsonTable{
        {"shard", to_text(one.shard)}, {"episodes", one.episodes}, {"command", one.command}});
    lines +=
        fmt::format("{}  # {} of shard {}\n", one.command,
                    counted(static_cast<std::size_t>(one.episodes), "episode"), to_text(one.shard));
  }
  print(json ? to_text(JsonTable{{"missing", documents}}) : lines);
  throw Error(Error::kUnavailable,
              fmt::format("{} of {} not finished; commands that finish them are on standard output",
                          missing.size(),
                          counted(static_cast<std::size_t>(missing.front().shard.count), "shard")));
}

void run(const MergeOptions& options) {
  const std::vector<fs::path> folders(options.folders.begin(), options.folders.end());
  const ShardSet shards(folders);
  const std::vector<MissingShard> missing = shards.missing();
  if (!missing.empty()) refuse_missing(missing, options.json);
  const fs::path first = shards.parts().front().folder;
  const fs::path out =
      options.out.empty() ? fs::canonical(first).parent_path() : fs::path(options.out);
  if (shards.header().kind == kEvaluationKind) return merge_evaluation(shards, out, options.json);
  if (shards.header().kind == kProbeKind) return merge_probes(shards, out, options.json);
  if (shards.header().kind == kCollectionKind) {
    return merge_collection(shards, out, options.json);
  }
  throw Error(Error::kIo, "'" + first.string() + "' is of a run of '" + shards.header().kind +
                              "', which this engram does not know");
}

}  // namespace

void add_merge_command(const Command& program) {
  const auto options = std::make_shared<MergeOptions>();
  const Command command =
      program.add_command("merge", "One result of the shards of a run (--shard I/N)");
  command
      .add_option("folders", options->folders,
                  "Folders shard-I-of-N, or those that have them, as --out of the shards")
      .type_name("FOLDER")
      .required();
  command
      .add_option("--out", options->out,
                  "Where results go, as of a run in one process; default: beside the shards")
      .type_name("DIR");
  add_json(command, options->json);
  command.footer(
      "The files are the same bytes as those of one process. Where episodes are missing, it prints "
      "the commands that play them, and ends with exit code 1.");
  command.on_run([options] { run(*options); });
}

}  // namespace engram::apps
