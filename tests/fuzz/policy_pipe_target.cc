// The pipe of an external policy: whatever its other end says.
#include <fcntl.h>
#include <unistd.h>

#include "protocol/evaluation/policy_process.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

constexpr std::uint8_t kGreeting[] = {1,   0,   0,   0,   8, 0, 0, 0,  // a greeting of 8 bytes
                                      'E', 'N', 'G', 'M', 1, 0, 0, 0};

// A pipe that says these bytes and is closed then.
int pipe_with(Data greeting, Data data) {
  int ends[2];
  require(::pipe2(ends, O_CLOEXEC) == 0, "no pipe");
  ssize_t written = ::write(ends[1], greeting.data(), greeting.size());
  written += ::write(ends[1], data.data(), data.size());
  ::close(ends[1]);
  require(written == static_cast<ssize_t>(greeting.size() + data.size()), "pipe too small");
  return ends[0];
}

void talk(int from, int rows) {
  const int to = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> steps = 0;
  const WorkContext context(0, stopped, steps);
  PolicyProcess policy(to, from, {.command = "fuzz", .environment = {}}, context);
  const std::vector<std::int32_t> numbers(static_cast<std::size_t>(rows));
  const std::vector<std::uint8_t> first(numbers.size());
  const std::vector<std::string> instructions(numbers.size(), "touch it");
  const std::vector<float> proprio(7 * numbers.size());
  PolicyRequest request;
  request.env_id = "RememberColor3-VLA-v0";
  request.count = rows;
  request.slots = request.episodes = request.steps = numbers;
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
}

}  // namespace

void fuzz_policy_pipe(Data data) {
  Input input(data);
  const int mode = input.take<std::uint8_t>();
  const Data greeting = (mode & 1) != 0 ? Data(kGreeting) : Data();
  const Data said = input.take_bytes(60'000);  // a pipe holds 64 KiB
  accepted([&] { talk(pipe_with(greeting, said), 1 + (mode >> 1) % 3); });
}

}  // namespace engram::fuzz
