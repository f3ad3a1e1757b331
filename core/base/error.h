// The one exception type of the library.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace engram {

// The message says what was wrong, what was given and what is allowed, in one line. A call that
// throws leaves everything as it was, unless its documentation says otherwise.
class Error : public std::runtime_error {
 public:
  enum class Kind {
    kInvalidArgument,  // a value outside what is allowed, or of the wrong shape
    kUnknownId,        // no task, option or field of that name
    kUnavailable,      // the machine lacks what was asked for (threads, memory, a device)
    kBadState,         // the call is not allowed at this point
    kIo,               // a file could not be read or written
    kInternal,         // a defect of the library itself
    kTaskFailed,       // the code of a user's task has failed
  };
  // Short names. `using enum` would do, but crashes GCC 12 when a template uses them.
  static constexpr Kind kInvalidArgument = Kind::kInvalidArgument;
  static constexpr Kind kUnknownId = Kind::kUnknownId;
  static constexpr Kind kUnavailable = Kind::kUnavailable;
  static constexpr Kind kBadState = Kind::kBadState;
  static constexpr Kind kIo = Kind::kIo;
  static constexpr Kind kInternal = Kind::kInternal;
  static constexpr Kind kTaskFailed = Kind::kTaskFailed;

  Error(Kind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}

  Kind kind() const noexcept { return kind_; }

 private:
  Kind kind_;
};

// Throws Error (kInvalidArgument) with both numbers unless they are equal: the length check of
// everything that takes arrays.
void require_length(const char* what, std::size_t given, std::size_t needed);

}  // namespace engram
