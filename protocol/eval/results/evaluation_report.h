// The report of an evaluation for people: rates as charts and tables, images, timing.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "protocol/eval/results/result_files.h"
#include "protocol/io/bytes.h"

namespace engram {

struct ReportContext {
  std::string compute;      // the machine, as text
  double wall_seconds = 0;  // since the run began or was resumed
};

// An HTML document. thread_seconds, samples (PNG): by task id, where there are any.
std::string evaluation_report(const EvaluationSettings& settings, const JsonList& tasks,
                              const std::map<std::string, double>& thread_seconds,
                              const std::map<std::string, Bytes>& samples,
                              const ReportContext& context);

}  // namespace engram
