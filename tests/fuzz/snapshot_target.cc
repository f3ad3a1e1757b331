// Snapshots of any content: damaged ones are refused, and what was made up with a right checksum
// does no harm either.
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/checksum.h"
#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/batch/scripted_policy.h"
#include "core/batch/snapshot.h"
#include "protocol/make/episode_words.h"
#include "protocol/make/make.h"
#include "tasks/family_samples.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

constexpr std::size_t kHeader = 48;
constexpr std::size_t kChecksumAt = 16;
constexpr std::size_t kLabelBytesAt = 40;

// One id of every family.
const std::vector<std::string>& ids() {
  static const std::vector<std::string> all = one_of_each_family();
  return all;
}

struct Saved {
  std::unique_ptr<Batch> batch;
  std::vector<std::byte> early;
  std::vector<std::byte> late;
};

// A batch after some steps. `physics`: really simulated.
Saved& batch(int id, bool physics) {
  static std::map<int, Saved> batches;
  Saved& saved = batches[2 * id + (physics ? 1 : 0)];
  if (saved.batch == nullptr) {
    BatchOptions options;
    options.num_envs = 1;
    options.threads = 1;
    options.substeps = physics ? 1 : 0;
    options.reward_mode = RewardMode::kDense;
    options.auto_reset = AutoReset::kSameStep;
    saved.batch = make(ids()[static_cast<std::size_t>(id)], options);
    saved.batch->reset();
    saved.early = Snapshotter(*saved.batch).save();
    std::vector<float> actions(7);
    for (int i = 0; i < 8; ++i) {
      ScriptedPolicy(*saved.batch, Policy::kOracle).act(actions);
      saved.batch->step(actions);
    }
    saved.late = Snapshotter(*saved.batch).save();
  }
  return saved;
}

void put(std::vector<std::byte>& bytes, std::size_t at, Data value) {
  for (std::size_t i = 0; i < value.size() && at + i < bytes.size(); ++i) {
    bytes[at + i] = static_cast<std::byte>(value[i]);
  }
}

void fix_checksum(std::vector<std::byte>& bytes) {
  if (bytes.size() < kHeader) return;
  std::memset(bytes.data() + kChecksumAt, 0, sizeof(std::uint64_t));
  const std::uint64_t sum = checksum(std::span<const std::byte>(bytes));
  std::memcpy(bytes.data() + kChecksumAt, &sum, sizeof sum);
}

// Values in the place of others: anywhere, or in an element of one of the columns.
void edit(const Batch& batch, Input& input, std::vector<std::byte>& bytes) {
  const std::size_t outputs_at = bytes.size() - BatchAccess::data(batch).outputs.row_bytes();
  std::uint64_t label_bytes = 0;
  std::memcpy(&label_bytes, bytes.data() + kLabelBytesAt, sizeof label_bytes);
  const std::size_t memory_at = kHeader + label_bytes;
  while (!input.empty()) {
    const int kind = input.choice(4);
    if (kind == 0) {
      const auto at = input.take<std::uint16_t>();
      put(bytes, at, input.take_bytes(8));
      continue;
    }
    const ColumnStore& store =
        kind == 1 ? BatchAccess::data(batch).outputs : BatchAccess::data(batch).memory;
    std::size_t at = kind == 1 ? outputs_at : memory_at;
    const std::size_t column = input.take<std::uint8_t>() % store.size();
    for (std::size_t i = 0; i < column; ++i) {
      const Field& field = *store[i].field;
      at += size_of(field.dtype) * static_cast<std::size_t>(field.width);
    }
    const Field& field = *store[column].field;
    at +=
        size_of(field.dtype) * (input.take<std::uint8_t>() % static_cast<std::size_t>(field.width));
    put(bytes, at, input.take_bytes(size_of(field.dtype)));
  }
}

// Everything that reads what was restored.
void use(Batch& batch) {
  std::vector<float> actions(7);
  Overlay overlay;
  SceneRenderer(batch).overlay(0, overlay);
  require(!Queries(batch).instruction(0).empty(), "no instruction");
  (void)Queries(batch).cue_end(0);
  require(!describe_words(batch, 0).empty(), "no words");
  for (const Policy policy : {Policy::kOracle, Policy::kBlind, Policy::kRandom}) {
    ScriptedPolicy(batch, policy).act(actions);
    for (float& action : actions) action = std::isfinite(action) ? action : 0.0F;
    batch.step(actions);
  }
}

}  // namespace

void fuzz_snapshot(Data data) {
  Input input(data);
  const int flags = input.take<std::uint8_t>();
  Saved& saved = batch(input.choice(ids().size()), (flags & 7) == 7);
  Batch& batch = *saved.batch;
  Snapshotter(batch).restore(saved.late);
  std::vector<std::byte> bytes = (flags & 8) != 0 ? saved.early : saved.late;
  if ((flags & 48) == 48) {  // any bytes at all
    bytes.resize(input.rest().size());
    put(bytes, 0, input.rest());
  } else {
    edit(batch, input, bytes);
    if ((flags & 64) != 0) fix_checksum(bytes);
  }
  if (!accepted([&] { Snapshotter(batch).restore(bytes); })) {
    require(Snapshotter(batch).save() == saved.late, "a refused snapshot changed something");
    return;
  }
  // Observations are computed again; everything else is as given.
  const std::vector<std::byte> taken = Snapshotter(batch).save();
  Snapshotter(batch).restore(taken);
  require(Snapshotter(batch).save() == taken, "a restored snapshot differs from what was given");
  use(batch);
}

}  // namespace engram::fuzz
