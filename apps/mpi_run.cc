#include "apps/mpi_run.h"

#include <span>
#include <string_view>

#include "apps/output.h"
#include "core/base/error.h"
#include "protocol/make/definitions.h"

namespace engram::apps {

namespace {

// A process that cannot talk to others works alone: launchers' variables also reach programs that
// they have not started themselves.
std::unique_ptr<Ranks> join_or_stay_alone() {
  try {
    return join_ranks();
  } catch (const Error& error) {
    print_warning(error.what() + std::string("; this process works alone"));
    return std::make_unique<Ranks>();
  }
}

}  // namespace

void with_mpi(const std::function<void(Ranks&)>& body) {
  const std::unique_ptr<Ranks> ranks = join_or_stay_alone();
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

Bytes definitions_message(const std::vector<std::string>& ids) {
  const std::string text = to_line(definitions_of(ids));
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void require_definitions_of_root(const std::vector<std::string>& ids, const Bytes& message) {
  const std::string_view text(reinterpret_cast<const char*>(message.data()), message.size());
  require_definitions(ids, parse_json(text).value_or(Json()), "rank 0");
}

}  // namespace engram::apps
