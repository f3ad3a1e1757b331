#include "protocol/eval/merged_evaluation.h"

#include "protocol/io/html.h"

namespace engram {

EvaluationRun merge_evaluation(const ShardSet& shards, const std::filesystem::path& out,
                               std::vector<std::string> command) {
  EvaluationSettings settings =
      EvaluationSettings::of(shards.header().run, shards.parts().front().folder / kJournalFile);
  PolicyIdentity policy(std::nullopt);  // refuses another one before there is a folder
  for (const ShardSet::Part& part : shards.parts()) {
    policy.take(PolicyIdentity::in(OpenFolder(part.folder)));
  }
  ResultFolder folder = ResultFolder::create(out, settings);
  EvaluationRun run(std::move(settings), std::move(folder), {.command = std::move(command)});
  for (const ShardSet::Part& part : shards.parts()) {
    run.store().journal->add(part.records);
  }
  run.identity()->take(policy.document());
  Protocol protocol;
  static_cast<RunOptions&>(protocol) = run.settings();
  protocol.threads = 1;
  Ranks alone;
  evaluate(alone, run.open_tasks(), protocol,
           {.finished = [&run](const TaskResult& result) { run.add(result); }, .tick = {}},
           run.store());
  run.finish("merged from " + counted(shards.parts().size(), "shard"), /*keep_sealed=*/true);
  return run;
}

}  // namespace engram
