// Results of a finished or interrupted evaluation, read for tables and comparisons. Those of other
// versions are read as well: keys are only ever added.
#pragma once

#include <string>

#include "protocol/io/json.h"

namespace engram {

struct ResultSet {
  std::string source;  // for messages
  JsonList tasks;      // in the registry's order
};

// source: the folder of a run, one task's file in it, a file with what `engram eval --json` has
// printed, or the text of such a document. Throws Error: kIo if it cannot be read,
// kInvalidArgument if it holds no results, or edited ones.
ResultSet read_results(const std::string& source);

}  // namespace engram
