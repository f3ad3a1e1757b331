// Messages between this process and one that it has started, with descriptors beside them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace engram::apps {

// A descriptor that is closed at the end.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor();

  int number() const { return number_; }

 private:
  int number_ = -1;
};

// One end of a pair of sockets. A message is its length (four bytes, the lowest first), then so
// many bytes.
class MessageSocket {
 public:
  MessageSocket() = default;
  explicit MessageSocket(Descriptor end) : end_(std::move(end)) {}
  // Both ends. Throws Error (kUnavailable) if the system refuses.
  static std::pair<MessageSocket, Descriptor> pair();

  // Both return false, or nothing, once the other end is gone. passed: a descriptor to hand over;
  // -1: none.
  bool send(std::string_view message, int passed = -1);
  std::optional<std::string> receive();

 private:
  Descriptor end_;
};

}  // namespace engram::apps
