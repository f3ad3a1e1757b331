#include "apps/message_socket.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "core/base/error.h"

namespace engram::apps {
namespace {

constexpr std::size_t kLengthBytes = 4;
constexpr std::size_t kLongest = std::size_t{1} << 28;

bool receive_all(int socket, std::span<char> out) {
  while (!out.empty()) {
    const ssize_t got = ::recv(socket, out.data(), out.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    out = out.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

bool send_all(int socket, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

// Sends the first bytes together with a descriptor.
bool send_with(int socket, std::span<char> bytes, int passed) {
  iovec piece = {bytes.data(), bytes.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(header), &passed, sizeof passed);
  ssize_t sent = 0;
  do {
    sent = ::sendmsg(socket, &message, MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(bytes.size());
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

std::pair<MessageSocket, Descriptor> MessageSocket::pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw Error(Error::kUnavailable,
                std::string("no socket for a task's process: ") + std::strerror(errno));
  }
  return {MessageSocket(Descriptor(ends[0])), Descriptor(ends[1])};
}

bool MessageSocket::send(std::string_view message, int passed) {
  std::array<char, kLengthBytes> length{};
  for (std::size_t i = 0; i < kLengthBytes; ++i) {
    length[i] = static_cast<char>(message.size() >> 8 * i & 0xff);
  }
  const int socket = end_.number();
  if (passed >= 0) return send_with(socket, length, passed) && send_all(socket, message);
  std::string whole(length.data(), length.size());
  whole += message;
  return send_all(socket, whole);
}

std::optional<std::string> MessageSocket::receive() {
  std::array<char, kLengthBytes> bytes{};
  if (!receive_all(end_.number(), bytes)) return std::nullopt;
  std::size_t length = 0;
  for (std::size_t i = 0; i < kLengthBytes; ++i) {
    length |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[i])) << 8 * i;
  }
  if (length > kLongest) return std::nullopt;
  std::string message(length, '\0');
  if (!receive_all(end_.number(), message)) return std::nullopt;
  return message;
}

}  // namespace engram::apps
