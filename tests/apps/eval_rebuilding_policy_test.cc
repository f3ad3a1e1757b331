// A policy that cheats: it looks up which episode it is in, makes it again with engram itself, and
// plays what the oracle plays there. Run as a policy's process by sealed evaluations' tests.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <memory>
#include <optional>

#include "core/batch/scripted_policy.h"
#include "protocol/eval/policies/seed_commitment.h"
#include "protocol/eval/run/evaluate.h"
#include "protocol/io/bytes.h"
#include "protocol/make/make.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

constexpr std::uint32_t kHello = 1;
constexpr std::uint32_t kTask = 2;
constexpr std::uint32_t kRequest = 3;
constexpr std::uint32_t kChunks = 4;

struct Message {
  std::uint32_t type = 0;
  Bytes body;
};

bool read_exactly(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

std::optional<Message> receive() {
  Bytes head(8);
  if (!read_exactly(head)) return std::nullopt;
  ByteReader in(head);
  Message message;
  message.type = in.get<std::uint32_t>();
  message.body.resize(in.get<std::uint32_t>());
  if (!read_exactly(message.body)) return std::nullopt;
  return message;
}

void send(std::uint32_t type, const Bytes& body) {
  ByteWriter out;
  out.put(type);
  out.put(static_cast<std::uint32_t>(body.size()));
  out.append(std::span<const std::byte>(body));
  const Bytes bytes = out.take();
  REQUIRE(::write(STDOUT_FILENO, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
}

// An episode that is believed to be the one under way.
class Rebuilt {
 public:
  Rebuilt(const std::string& id, std::uint64_t seed) {
    MakeOptions options;
    options.num_envs = 1;
    options.threads = 1;
    options.seed = seed;
    options.obs_mode = ObsMode::kObjects;
    options.auto_reset = AutoReset::kOff;
    batch_ = make(id, options);
    batch_->reset();
  }

  bool looks_like(std::span<const float> row) const {
    const auto own = batch_->outputs().observation;
    return std::ranges::equal(own, row);
  }

  std::vector<float> act() {
    std::vector<float> action(7);
    ScriptedPolicy(*batch_, Policy::kOracle).act(action);
    if ((batch_->outputs().terminated[0] | batch_->outputs().truncated[0]) == 0)
      batch_->step(action);
    return action;
  }

 private:
  std::unique_ptr<Batch> batch_;
};

// Everything that is public: the protocol's seeds, and how numbers follow from them. The number of
// the episode where it is told, its opaque number otherwise, then what it looks like; at last the
// order in which episodes begin.
std::unique_ptr<Rebuilt> rebuild(const std::string& id, std::int32_t number,
                                 std::span<const float> row, int begun) {
  for (int i = 0; i < kBenchmarkEpisodes; ++i) {
    const std::uint64_t seed = kBenchmarkSeed + static_cast<std::uint64_t>(i);
    if (number != i && number != opaque_number({}, id, seed)) continue;
    return std::make_unique<Rebuilt>(id, seed);
  }
  for (int i = 0; i < kBenchmarkEpisodes; ++i) {
    auto found = std::make_unique<Rebuilt>(id, kBenchmarkSeed + static_cast<std::uint64_t>(i));
    if (found->looks_like(row)) return found;
  }
  return std::make_unique<Rebuilt>(
      id, kBenchmarkSeed + static_cast<std::uint64_t>(begun % kBenchmarkEpisodes));
}

class Cheat {
 public:
  void begin_task(ByteReader in) {
    id_ = in.text();
    state_dim_ = in.get<std::uint32_t>();
    begun_ = 0;
  }

  Bytes answer(ByteReader in) {
    const auto count = in.get<std::uint32_t>();
    const auto slots = in.values<std::int32_t>(count);
    const auto numbers = in.values<std::int32_t>(count);
    (void)in.values<std::int32_t>(count);
    const auto first = in.values<std::uint8_t>(count);
    for (std::uint32_t i = 0; i < count; ++i) (void)in.text();
    (void)in.values<float>(std::size_t{7} * count);
    const auto rows = in.values<float>(std::size_t{state_dim_} * count);
    ByteWriter out;
    out.put(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      std::unique_ptr<Rebuilt>& episode = episodes_[slots[i]];
      if (first[i] != 0) {
        const auto row = std::span(rows).subspan(std::size_t{i} * state_dim_, state_dim_);
        episode = rebuild(id_, numbers[i], row, begun_++);
      }
      out.put(std::uint32_t{1});
      out.put(std::uint32_t{7});
      out.append(std::span<const float>(episode->act()));
    }
    return out.take();
  }

 private:
  std::string id_;
  std::uint32_t state_dim_ = 0;
  int begun_ = 0;
  std::map<std::int32_t, std::unique_ptr<Rebuilt>> episodes_;
};

}  // namespace

TEST_CASE("A policy that rebuilds its episodes", "[.rebuilding-policy]") {
  Cheat cheat;
  while (const std::optional<Message> message = receive()) {
    ByteReader in(message->body);
    if (message->type == kHello) {
      ByteWriter out;
      out.put(in.get<std::uint32_t>());  // the magic number
      out.put(in.get<std::uint32_t>());  // the version
      send(kHello, out.take());
    }
    if (message->type == kTask) cheat.begin_task(in);
    if (message->type == kRequest) send(kChunks, cheat.answer(in));
  }
}

}  // namespace engram
