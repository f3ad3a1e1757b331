// Format: a header, the label, then the rows of each environment's columns as bytes. Physics keeps
// nothing outside the columns, so there is nothing else to save. Answers that a caller has named
// (core/task/answer_controller.h) are no part of an environment.
#include "core/batch/snapshot.h"

#include <algorithm>
#include <cstring>

#include "core/base/checksum.h"
#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/join.h"

namespace engram {
namespace {

constexpr char kMagic[8] = {'e', 'n', 'g', 'r', 'a', 'm', 's', 'n'};
constexpr std::uint32_t kVersion = 6;

struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint32_t num_envs;
  std::uint64_t checksum;  // of everything, with zero in this place
  std::uint64_t bytes;     // of the whole snapshot
  std::uint64_t columns;   // which quantities a row holds
  std::uint64_t label_bytes;
};
static_assert(sizeof(Header) == 48);

[[noreturn]] void refuse(const std::string& why) {
  throw Error(Error::kInvalidArgument, "snapshot refused: " + why);
}

std::uint64_t snapshot_checksum(Header header, std::span<const std::byte> behind) {
  header.checksum = 0;
  return checksum(behind, checksum(std::as_bytes(std::span(&header, 1))));
}

// Reads the header of bytes that are whole: of this version, complete and undamaged.
Header read_header(std::span<const std::byte> bytes) {
  Header header{};
  if (bytes.size() < sizeof header) {
    refuse(std::to_string(bytes.size()) + " bytes given, too short for a header");
  }
  std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) refuse("not a snapshot of engram");
  if (header.version != kVersion) {
    refuse("version " + std::to_string(header.version) + " given, " + std::to_string(kVersion) +
           " needed");
  }
  if (header.bytes != bytes.size()) {
    refuse(std::to_string(bytes.size()) + " bytes given, " + std::to_string(header.bytes) +
           " needed by its header");
  }
  const std::span<const std::byte> behind = bytes.subspan(sizeof header);
  if (snapshot_checksum(header, behind) != header.checksum) {
    refuse("its content is damaged (checksum differs)");
  }
  return header;
}

// True for constants that fix the meaning of the columns. Beginning and end of an episode are up to
// the batch that goes on with a snapshot.
bool is_of_state(const std::string& constant) {
  return constant != kHorizonConstant && constant != kNoiseConstant;
}

}  // namespace

// Everything that the columns' meaning depends on, in words: task, changed constants, control mode,
// rules and the task's options.
std::string Snapshotter::label() const {
  const TaskInfo& info = batch_.info();
  const BatchOptions& options = batch_.options();
  std::string label = info.id;
  for (const auto& [name, value] : changed_constants(info.constants)) {
    if (is_of_state(name)) label += ", " + name + "=" + in_words(value);
  }
  label += std::string(", ") + name_of(batch_.control_mode()) + ", rules=" + name_of(options.rules);
  for (std::size_t i = 0; i < batch_.option_values_.size(); ++i) {
    label += ", " + info.options[i].name + "=" + shortest(batch_.option_values_[i]);
  }
  // Their levels count for the next episodes only.
  for (std::size_t i = 0; i < kPerturbationAxes; ++i) {
    const auto axis = static_cast<PerturbationAxis>(i);
    if (batch_.perturbations_.has(axis)) label += std::string(", perturbed ") + name_of(axis);
  }
  return label;
}

std::uint64_t Snapshotter::columns() const {
  std::uint64_t hash = kChecksumSeed;
  for (const ColumnStore* store : {&batch_.memory_, &batch_.pin_memory_, &batch_.outputs_}) {
    hash = hash * 31 + store->signature();
  }
  return hash;
}

std::size_t Snapshotter::row_bytes() const {
  return batch_.memory_.row_bytes() + batch_.pin_memory_.row_bytes() + batch_.outputs_.row_bytes();
}

std::size_t Snapshotter::size_of(int count) const {
  batch_.require_started("save");
  return sizeof(Header) + label().size() + static_cast<std::size_t>(count) * row_bytes();
}

std::vector<std::byte> Snapshotter::save_range(Range envs) const {
  const std::string text = label();
  std::vector<std::byte> bytes(size_of(envs.end - envs.begin));
  const std::span<std::byte> behind = std::span(bytes).subspan(sizeof(Header));
  std::memcpy(behind.data(), text.data(), text.size());
  std::span<std::byte> rest = behind.subspan(text.size());
  for (int env = envs.begin; env < envs.end; ++env) {
    for (const ColumnStore* store : {&batch_.memory_, &batch_.pin_memory_, &batch_.outputs_}) {
      store->save_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
  }
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  header.num_envs = static_cast<std::uint32_t>(envs.end - envs.begin);
  header.bytes = bytes.size();
  header.columns = columns();
  header.label_bytes = text.size();
  header.checksum = snapshot_checksum(header, behind);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

// The checksum finds accidents, not bytes that were made up. So indices and pins must have
// values that an episode can have. Other columns may hold any value: at worst it ends the episode.
void Snapshotter::check_content(std::span<const std::byte> row) const {
  for (const ColumnStore* store : {&batch_.memory_, &batch_.pin_memory_, &batch_.outputs_}) {
    const ColumnView bad = store->find_beyond_limits(row);
    if (bad.field != nullptr) {
      refuse("'" + bad.field->name + "' has a value that no episode of " + batch_.info().id +
             " has");
    }
    if (store == &batch_.pin_memory_) batch_.pins_.check_saved(row);
    row = row.subspan(store->row_bytes());
  }
}

// Throws Error unless the bytes are `count` environments that fit this batch.
void Snapshotter::check(std::span<const std::byte> bytes, int count) const {
  const Header header = read_header(bytes);
  const std::span<const std::byte> behind = bytes.subspan(sizeof header);
  const std::string own = label();
  const std::string given(reinterpret_cast<const char*>(behind.data()),
                          std::min<std::size_t>(header.label_bytes, behind.size()));
  if (given != own) refuse("it is of " + given + "; this batch is of " + own);
  if (header.columns != columns()) {
    refuse("it is of another build of engram, with other columns of " + own);
  }
  if (header.num_envs != static_cast<std::uint32_t>(count)) {
    refuse(std::to_string(header.num_envs) + " environments given, " + std::to_string(count) +
           " needed");
  }
  const std::size_t content = behind.size() - own.size();
  const std::size_t needed = static_cast<std::size_t>(count) * row_bytes();
  if (content != needed) {
    refuse(std::to_string(content) + " bytes of content given, " + std::to_string(needed) +
           " needed");
  }
  for (int i = 0; i < count; ++i) {
    check_content(
        behind.subspan(own.size() + static_cast<std::size_t>(i) * row_bytes(), row_bytes()));
  }
}

void Snapshotter::restore_range(Range envs, std::span<const std::byte> bytes) const {
  const IeeeScope scope;
  const int count = envs.end - envs.begin;
  check(bytes, count);
  std::span<const std::byte> rest = bytes.last(static_cast<std::size_t>(count) * row_bytes());
  const Column<float>& observation = batch_.observation_;
  for (int env = envs.begin; env < envs.end; ++env) {
    for (ColumnStore* store : {&batch_.memory_, &batch_.pin_memory_, &batch_.outputs_}) {
      store->load_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
    batch_.final_mask_[static_cast<std::size_t>(env)] = 0;
    // The snapshot may be of a batch with other observations; this batch makes its own.
    std::fill_n(observation.row(env), observation.width(), 0.0F);
  }
  batch_.observe(envs);
  for (int env = envs.begin; env < envs.end; ++env) batch_.render_observation(0, env);
  batch_.copy_outputs(envs);
}

std::vector<std::byte> Snapshotter::save(int env) const {
  batch_.check_env(env);
  return save_range({env, env + 1});
}

std::vector<std::byte> Snapshotter::save() const { return save_range({0, batch_.num_envs()}); }

std::size_t Snapshotter::save_size(int env) const {
  batch_.check_env(env);
  return size_of(1);
}

std::size_t Snapshotter::save_size() const { return size_of(batch_.num_envs()); }

void Snapshotter::restore(int env, std::span<const std::byte> bytes) const {
  batch_.check_env(env);
  batch_.require_started("restore");
  restore_range({env, env + 1}, bytes);
}

void Snapshotter::check(std::span<const std::byte> bytes) const { check(bytes, batch_.num_envs()); }

void Snapshotter::restore(std::span<const std::byte> bytes) const {
  restore_range({0, batch_.num_envs()}, bytes);
  batch_.started_ = true;
  batch_.interrupted_ = false;
}

}  // namespace engram
