// Snapshots: a header that says what follows, then the rows of an environment's columns as bytes.
// Physics keeps nothing outside the columns, so there is nothing else to save.
#include <algorithm>
#include <cstring>

#include "core/base/checksum.h"
#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/join.h"
#include "core/env/batch.h"

namespace engram {
namespace {

constexpr char kMagic[8] = {'e', 'n', 'g', 'r', 'a', 'm', 's', 'n'};
constexpr std::uint32_t kVersion = 5;

// Header, label, then the rows of the environments.
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

// The header of bytes that are whole: of this version, complete and undamaged.
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

// Where an episode begins and ends is up to the batch that goes on with a snapshot.
bool is_of_state(const std::string& constant) {
  return constant != kHorizonConstant && constant != kNoiseConstant;
}

}  // namespace

// What the columns' meaning depends on, in words: task, changed constants, control mode, rules and
// the task's options.
std::string Batch::snapshot_label() const {
  std::string label = info().id;
  for (const auto& [name, value] : changed_constants(info().constants)) {
    if (is_of_state(name)) label += ", " + name + "=" + in_words(value);
  }
  label +=
      std::string(", ") + name_of(options_.control_mode) + ", rules=" + name_of(options_.rules);
  for (std::size_t i = 0; i < option_values_.size(); ++i) {
    label += ", " + info().options[i].name + "=" + shortest(option_values_[i]);
  }
  return label;
}

std::uint64_t Batch::snapshot_columns() const {
  std::uint64_t hash = kChecksumSeed;
  for (const ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
    hash = hash * 31 + store->signature();
  }
  return hash;
}

std::size_t Batch::snapshot_row_bytes() const {
  return memory_.row_bytes() + pin_memory_.row_bytes() + outputs_.row_bytes();
}

std::size_t Batch::snapshot_bytes(int count) const {
  if (!started_) throw Error(Error::kBadState, "save before the first reset; reset first");
  return sizeof(Header) + snapshot_label().size() +
         static_cast<std::size_t>(count) * snapshot_row_bytes();
}

std::vector<std::byte> Batch::save_range(Range envs) const {
  const std::string label = snapshot_label();
  std::vector<std::byte> bytes(snapshot_bytes(envs.end - envs.begin));
  const std::span<std::byte> behind = std::span(bytes).subspan(sizeof(Header));
  std::memcpy(behind.data(), label.data(), label.size());
  std::span<std::byte> rest = behind.subspan(label.size());
  for (int env = envs.begin; env < envs.end; ++env) {
    for (const ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
      store->save_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
  }
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  header.num_envs = static_cast<std::uint32_t>(envs.end - envs.begin);
  header.bytes = bytes.size();
  header.columns = snapshot_columns();
  header.label_bytes = label.size();
  header.checksum = snapshot_checksum(header, behind);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

// The checksum finds accidents, not bytes that somebody made up. So indices and pins must have
// values that an episode can have. Other columns may hold any value: at worst it ends the episode.
void Batch::check_content(std::span<const std::byte> row) const {
  for (const ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
    const ColumnView bad = store->find_beyond_limits(row);
    if (bad.field != nullptr) {
      refuse("'" + bad.field->name + "' has a value that no episode of " + info().id + " has");
    }
    if (store == &pin_memory_) pins_.check_saved(row);
    row = row.subspan(store->row_bytes());
  }
}

// Throws Error unless the bytes are `count` environments that fit this batch.
void Batch::check_snapshot(std::span<const std::byte> bytes, int count) const {
  const Header header = read_header(bytes);
  const std::span<const std::byte> behind = bytes.subspan(sizeof header);
  const std::string own = snapshot_label();
  const std::string label(reinterpret_cast<const char*>(behind.data()),
                          std::min<std::size_t>(header.label_bytes, behind.size()));
  if (label != own) refuse("it is of " + label + "; this batch is of " + own);
  if (header.columns != snapshot_columns()) {
    refuse("it is of another build of engram, with other columns of " + label);
  }
  if (header.num_envs != static_cast<std::uint32_t>(count)) {
    refuse(std::to_string(header.num_envs) + " environments given, " + std::to_string(count) +
           " needed");
  }
  const std::size_t content = behind.size() - label.size();
  const std::size_t needed = static_cast<std::size_t>(count) * snapshot_row_bytes();
  if (content != needed) {
    refuse(std::to_string(content) + " bytes of content given, " + std::to_string(needed) +
           " needed");
  }
  for (int i = 0; i < count; ++i) {
    check_content(behind.subspan(label.size() + static_cast<std::size_t>(i) * snapshot_row_bytes(),
                                 snapshot_row_bytes()));
  }
}

void Batch::restore_range(Range envs, std::span<const std::byte> bytes) {
  const IeeeScope scope;
  const int count = envs.end - envs.begin;
  check_snapshot(bytes, count);
  std::span<const std::byte> rest =
      bytes.last(static_cast<std::size_t>(count) * snapshot_row_bytes());
  for (int env = envs.begin; env < envs.end; ++env) {
    for (ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
      store->load_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
    final_mask_[static_cast<std::size_t>(env)] = 0;
    // The snapshot may be of a batch with other observations; this batch makes its own.
    std::fill_n(observation_.row(env), observation_.width(), 0.0F);
    observe({env, env + 1});
    draw(0, env);
  }
}

std::vector<std::byte> Batch::save(int env) const {
  check_env(env);
  return save_range({env, env + 1});
}

std::size_t Batch::save_size(int env) const {
  check_env(env);
  return snapshot_bytes(1);
}

std::size_t Batch::save_size() const { return snapshot_bytes(num_envs()); }

void Batch::restore(int env, std::span<const std::byte> bytes) {
  check_env(env);
  if (!started_) throw Error(Error::kBadState, "restore before the first reset; reset first");
  restore_range({env, env + 1}, bytes);
}

std::vector<std::byte> Batch::save() const { return save_range({0, num_envs()}); }

void Batch::restore(std::span<const std::byte> bytes) {
  restore_range({0, num_envs()}, bytes);
  started_ = true;
}

}  // namespace engram
