// Snapshots: flat byte buffers of an environment's columns behind a header that tells what they
// are. Physics keeps nothing outside the columns, so this is all there is to save.
#include <cstring>

#include "core/checksum.h"
#include "core/error.h"
#include "core/vector_env.h"

namespace engram {
namespace {

constexpr char kMagic[8] = {'e', 'n', 'g', 'r', 'a', 'm', 's', 'n'};
constexpr std::uint32_t kVersion = 1;

struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint32_t num_envs;
  std::uint64_t layout;    // task, control mode and columns
  std::uint64_t checksum;  // of everything behind the header
};
static_assert(sizeof(Header) == 32);

[[noreturn]] void refuse(const std::string& why) {
  throw Error(Error::kInvalidArgument, "snapshot refused: " + why);
}

}  // namespace

std::uint64_t VectorEnv::snapshot_layout() const {
  std::uint64_t hash = checksum(info().id);
  hash = checksum(control_mode_name(options_.control_mode), hash);
  for (const ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
    hash = hash * 31 + store->signature();
  }
  return hash;
}

std::vector<std::byte> VectorEnv::save_range(Range envs) const {
  if (!started_) throw Error(Error::kBadState, "save before the first reset; reset first");
  const std::size_t row = memory_.row_bytes() + pin_memory_.row_bytes() + outputs_.row_bytes();
  const auto count = static_cast<std::size_t>(envs.end - envs.begin);
  std::vector<std::byte> bytes(sizeof(Header) + count * row);
  std::span<std::byte> body = std::span(bytes).subspan(sizeof(Header));
  for (std::size_t i = 0; i < count; ++i) {
    const int env = envs.begin + static_cast<int>(i);
    std::span<std::byte> rest = body.subspan(i * row, row);
    for (const ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
      store->save_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
  }
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  header.num_envs = static_cast<std::uint32_t>(count);
  header.layout = snapshot_layout();
  header.checksum = checksum(body);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

// A checksum keeps out accidents, not bytes that somebody has made up: what serves as an index, and
// pins, must be what an episode can have. Other values may be anything; they end an episode at
// worst.
void VectorEnv::check_content(std::span<const std::byte> row) const {
  for (const ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
    const ColumnView bad = store->find_beyond_limits(row);
    if (bad.field != nullptr) {
      refuse("'" + bad.field->name + "' has a value that no episode of " + info().id + " has");
    }
    if (store == &pin_memory_) pins_.check_saved(row);
    row = row.subspan(store->row_bytes());
  }
}

void VectorEnv::restore_range(Range envs, std::span<const std::byte> bytes) {
  const std::size_t row = memory_.row_bytes() + pin_memory_.row_bytes() + outputs_.row_bytes();
  const auto count = static_cast<std::size_t>(envs.end - envs.begin);
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
  if (header.layout != snapshot_layout()) {
    refuse("it is of another task, control mode or build; this batch is of " + info().id + ", " +
           control_mode_name(options_.control_mode));
  }
  if (header.num_envs != count) {
    refuse(std::to_string(header.num_envs) + " environments given, " + std::to_string(count) +
           " needed");
  }
  const std::span<const std::byte> body = bytes.subspan(sizeof header);
  if (body.size() != count * row) {
    refuse(std::to_string(body.size()) + " bytes of content given, " + std::to_string(count * row) +
           " needed");
  }
  if (checksum(body) != header.checksum) refuse("its content is damaged (checksum differs)");

  for (std::size_t i = 0; i < count; ++i) check_content(body.subspan(i * row, row));

  for (std::size_t i = 0; i < count; ++i) {
    const int env = envs.begin + static_cast<int>(i);
    std::span<const std::byte> rest = body.subspan(i * row, row);
    for (ColumnStore* store : {&memory_, &pin_memory_, &outputs_}) {
      store->load_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
    final_mask_[static_cast<std::size_t>(env)] = 0;
    draw(0, env);
  }
}

std::vector<std::byte> VectorEnv::save(int env) const {
  check_env(env);
  return save_range({env, env + 1});
}

void VectorEnv::restore(int env, std::span<const std::byte> bytes) {
  check_env(env);
  if (!started_) throw Error(Error::kBadState, "restore before the first reset; reset first");
  restore_range({env, env + 1}, bytes);
}

std::vector<std::byte> VectorEnv::save() const { return save_range({0, num_envs()}); }

void VectorEnv::restore(std::span<const std::byte> bytes) {
  restore_range({0, num_envs()}, bytes);
  started_ = true;
}

}  // namespace engram
