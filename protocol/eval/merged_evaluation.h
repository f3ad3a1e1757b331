// One result of the shards of an evaluation.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/eval/evaluation_run.h"
#include "protocol/parallel/shard_set.h"

namespace engram {

// Writes the results of one process into <out>/<split>/<date and time>/. Plays nothing: the shards
// have all episodes. command: the words of this program.
EvaluationRun merge_evaluation(const ShardSet& shards, const std::filesystem::path& out,
                               std::vector<std::string> command);

}  // namespace engram
