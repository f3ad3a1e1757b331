// Evaluations of one command line with several values of --replan and --history.
#pragma once

#include <string>
#include <vector>

#include "apps/eval_options.h"
#include "protocol/io/json.h"

namespace engram::apps {

// One of them: its values as given, and its options.
struct SweepPoint {
  std::string replan;
  std::string history;
  EvalOptions options;
};

// "last,since-last,8,2" as {"last", "since-last", "8,2"}.
std::vector<std::string> histories_in(const std::string& text);

// All pairs of the values; one point unless a list is given. Throws Error (kInvalidArgument) for
// lists with --resume.
std::vector<SweepPoint> sweep_of(const EvalOptions& options);

// {replan, history, summary, tasks} of a point whose evaluation has that document.
Json point_document(const SweepPoint& point, const Json& evaluation);
// A table of such documents.
std::string sweep_text(const JsonList& points);

}  // namespace engram::apps
