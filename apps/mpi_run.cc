#include "apps/mpi_run.h"

#include <span>
#include <string>

#include "apps/output.h"
#include "core/base/error.h"

namespace engram::apps {

namespace {

// A process that cannot talk to others works alone: launchers' variables also reach programs that
// they have not started themselves.
std::unique_ptr<Ranks> join_or_stay_alone(MpiMode mode) {
  try {
    return join_ranks(mode);
  } catch (const Error& error) {
    if (mode == MpiMode::kOn) throw;
    print_warning(error.what() + std::string("; this process works alone"));
    return std::make_unique<Ranks>();
  }
}

}  // namespace

void with_mpi(MpiMode mode, const std::function<void(Ranks&)>& body) {
  const std::unique_ptr<Ranks> ranks = join_or_stay_alone(mode);
  try {
    body(*ranks);
  } catch (const std::exception& error) {
    if (!ranks->is_single()) {
      print_error(error.what());
      ranks->abort();
    }
    throw;
  }
}

Json broadcast(Ranks& ranks, const Json& document) {
  const std::string text = to_line(document);
  const auto bytes = std::as_bytes(std::span(text));
  const Bytes sent = engram::broadcast(ranks, {bytes.begin(), bytes.end()});
  return parse_json({reinterpret_cast<const char*>(sent.data()), sent.size()}).value_or(Json());
}

}  // namespace engram::apps
