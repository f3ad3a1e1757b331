#include "api/c_error.h"

#include <algorithm>
#include <array>
#include <exception>
#include <new>
#include <span>
#include <system_error>

#include "core/base/error.h"
#include "protocol/io/printable.h"

namespace engram::c {
namespace {

// Long enough for the longest list of names that a message has; a longer message is cut off.
thread_local std::array<char, 4096> message_buffer = {};

engram_status status_of(Error::Kind kind) {
  switch (kind) {
    case Error::kInvalidArgument:
      return ENGRAM_INVALID_ARGUMENT;
    case Error::kUnknownId:
      return ENGRAM_UNKNOWN_ID;
    case Error::kUnavailable:
      return ENGRAM_UNAVAILABLE;
    case Error::kBadState:
      return ENGRAM_BAD_STATE;
    case Error::kIo:
      return ENGRAM_IO;
    case Error::kInternal:
      return ENGRAM_INTERNAL;
    case Error::kTaskFailed:
      return ENGRAM_TASK_FAILED;
  }
  return ENGRAM_INTERNAL;
}

// Names that users give may hold anything; a message is one line in UTF-8, and moves no cursor.
void make_printable(std::span<char> message) {
  while (!message.empty()) {
    const Letter letter = first_letter({message.data(), message.size()});
    if (!letter.printable()) std::ranges::fill(message.first(letter.length), '?');
    message = message.subspan(letter.length);
  }
}

}  // namespace

engram_status fail(engram_status status, std::string_view message) noexcept {
  const std::string_view fitting = message.substr(0, message_buffer.size() - 1);
  *std::copy(fitting.begin(), fitting.end(), message_buffer.begin()) = '\0';
  make_printable(std::span(message_buffer).first(fitting.size()));
  return status;
}

engram_status fail_with_current_exception() noexcept {
  try {
    throw;
  } catch (const Error& error) {
    return fail(status_of(error.kind()), error.what());
  } catch (const std::bad_alloc&) {
    return fail(ENGRAM_UNAVAILABLE, "out of memory");
  } catch (const std::system_error& error) {
    return fail(ENGRAM_UNAVAILABLE, error.what());
  } catch (const std::exception& error) {
    return fail(ENGRAM_INTERNAL, error.what());
  } catch (...) {
    return fail(ENGRAM_INTERNAL, "an unknown exception");
  }
}

const char* last_error() noexcept { return message_buffer.data(); }

}  // namespace engram::c
