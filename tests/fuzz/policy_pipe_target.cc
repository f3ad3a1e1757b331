// The pipe of an external policy, with arbitrary bytes from its other end.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <thread>
#include <utility>
#include <vector>

#include "protocol/eval/policies/policy_process.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

constexpr std::uint8_t kGreeting[] = {1,   0,   0,   0,   8, 0, 0, 0,  // a greeting of 8 bytes
                                      'E', 'N', 'G', 'M', 1, 0, 0, 0};

// The other end of both pipes: reads every message, and answers as long as input is left.
class Speaker {
 public:
  Speaker(Data greeting, Data said) : greeting_(greeting), said_(said) {
    require(::pipe2(to_.data(), O_CLOEXEC) == 0, "no pipe");
    require(::pipe2(from_.data(), O_CLOEXEC) == 0, "no pipe");
    thread_ = std::thread([this] { serve(); });
  }
  // The policy has closed its ends.
  ~Speaker() { thread_.join(); }
  Speaker(const Speaker&) = delete;
  Speaker& operator=(const Speaker&) = delete;

  int to() const { return to_[1]; }
  int from() const { return from_[0]; }

 private:
  static constexpr std::uint32_t kTask = 2;

  void serve() {
    std::array<std::uint32_t, 2> head{};
    std::vector<std::byte> body;
    while (hear(head.data(), sizeof head)) {
      body.resize(head[1]);
      if (!hear(body.data(), body.size())) break;
      if (head[0] == kTask) continue;
      say(greeting_.empty() ? next() : std::exchange(greeting_, {}));
      if (said_.empty()) break;  // half a message is not waited for
    }
    ::close(to_[0]);
    ::close(from_[1]);
  }

  // A message of its announced length, or the rest; sometimes with the next one.
  Data next() {
    std::uint32_t size = 0;
    if (said_.size() >= 8) std::memcpy(&size, said_.data() + 4, sizeof size);
    const bool twice = size % 16 == 15;
    const std::size_t length =
        twice ? said_.size() : std::min<std::size_t>(said_.size(), 8U + size);
    const Data message = said_.first(length);
    said_ = said_.subspan(length);
    return message;
  }
  bool hear(void* bytes, std::size_t size) const {
    auto* at = static_cast<char*>(bytes);
    while (size > 0) {
      const ssize_t count = ::read(to_[0], at, size);
      if (count <= 0) return false;
      at += count;
      size -= static_cast<std::size_t>(count);
    }
    return true;
  }
  // A pipe holds all of it.
  void say(Data bytes) const { (void)!::write(from_[1], bytes.data(), bytes.size()); }

  Data greeting_;
  Data said_;
  std::array<int, 2> to_{};
  std::array<int, 2> from_{};
  std::thread thread_;
};

void talk(Data greeting, Data said, int rows) {
  const std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> steps = 0;
  const WorkContext context(0, stopped, steps);
  const Speaker speaker(greeting, said);
  PolicyProcess policy(speaker.to(), speaker.from(), {.command = "fuzz", .environment = {}},
                       context);
  const std::vector<std::int32_t> numbers(static_cast<std::size_t>(rows));
  const std::vector<std::uint8_t> first(numbers.size());
  const std::vector<std::string> instructions(numbers.size(), "touch it");
  const std::vector<float> proprio(7 * numbers.size());
  PolicyRequest request;
  request.env_id = "RememberColor3-VLA-v0";
  request.count = rows;
  request.slots = request.episodes = request.numbers = request.steps = numbers;
  request.first = first;
  request.instructions = instructions;
  request.proprio = proprio;
  request.context = &context;
  for (int i = 0; i < 2; ++i) {
    PolicyReply reply(rows, 7);
    policy.act(request, reply);
    for (int row = 0; row < rows; ++row) {
      require(reply.chunk(row).size() % 7 == 0, "a chunk of parts of actions");
    }
  }
  policy.check_no_pending_reply();
}

}  // namespace

void fuzz_policy_pipe(Data data) {
  std::signal(SIGPIPE, SIG_IGN);  // as programs that have policies in processes do
  Input input(data);
  const int mode = input.take<std::uint8_t>();
  const Data greeting = (mode & 1) != 0 ? Data(kGreeting) : Data();
  const Data said = input.take_bytes(60'000);  // a pipe holds 64 KiB
  accepted([&] { talk(greeting, said, 1 + (mode >> 1) % 3); });
}

}  // namespace engram::fuzz
