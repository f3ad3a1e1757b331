#include "api/c_error.h"

#include <algorithm>
#include <array>
#include <exception>
#include <new>
#include <system_error>

#include "core/base/error.h"

namespace engram::c {
namespace {

// Room for the longest list of names that a message has; what does not fit is cut off.
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
  }
  return ENGRAM_INTERNAL;
}

// Names that users give may hold anything; a message is one line.
char printable(char letter) { return static_cast<unsigned char>(letter) < ' ' ? '?' : letter; }

}  // namespace

engram_status fail(engram_status status, std::string_view message) noexcept {
  const std::string_view fitting = message.substr(0, message_buffer.size() - 1);
  *std::transform(fitting.begin(), fitting.end(), message_buffer.begin(), printable) = '\0';
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
