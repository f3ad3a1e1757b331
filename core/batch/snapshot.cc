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
constexpr std::uint32_t kVersion = 7;

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

// Everything that the columns' meaning depends on, in words: task, changed constants, control mode,
// rules and the task's options.
std::string label_of(const BatchData& data) {
  const TaskInfo& info = data.info();
  const BatchOptions& options = data.options;
  std::string label = info.id;
  for (const auto& [name, value] : changed_constants(info.constants)) {
    if (is_of_state(name)) label += ", " + name + "=" + in_words(value);
  }
  label +=
      std::string(", ") + name_of(*data.options.control_mode) + ", rules=" + name_of(options.rules);
  for (std::size_t i = 0; i < data.option_values.size(); ++i) {
    label += ", " + info.options[i].name + "=" + shortest(data.option_values[i]);
  }
  if (options.physics != Physics::kEngram) {
    label += std::string(", physics=") + name_of(options.physics);
  }
  // Their levels count for the next episodes only.
  for (std::size_t i = 0; i < kPerturbationAxes; ++i) {
    const auto axis = static_cast<PerturbationAxis>(i);
    if (data.perturbations.has(axis)) label += std::string(", perturbed ") + name_of(axis);
  }
  return label;
}

std::uint64_t columns_of(const BatchData& data) {
  std::uint64_t hash = kChecksumSeed;
  for (const ColumnStore* store : {&data.memory, &data.pin_memory, &data.outputs}) {
    hash = hash * 31 + store->signature();
  }
  return hash;
}

std::size_t row_bytes_of(const BatchData& data) {
  return data.memory.row_bytes() + data.pin_memory.row_bytes() + data.outputs.row_bytes();
}

std::size_t size_of(const BatchData& data, int count) {
  data.require_started("save");
  return sizeof(Header) + label_of(data).size() + at(count) * row_bytes_of(data);
}

std::vector<std::byte> save_range(const BatchData& data, Range envs) {
  const std::string text = label_of(data);
  std::vector<std::byte> bytes(size_of(data, envs.end - envs.begin));
  const std::span<std::byte> behind = std::span(bytes).subspan(sizeof(Header));
  std::memcpy(behind.data(), text.data(), text.size());
  std::span<std::byte> rest = behind.subspan(text.size());
  for (int env = envs.begin; env < envs.end; ++env) {
    for (const ColumnStore* store : {&data.memory, &data.pin_memory, &data.outputs}) {
      store->save_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
  }
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  header.num_envs = static_cast<std::uint32_t>(envs.end - envs.begin);
  header.bytes = bytes.size();
  header.columns = columns_of(data);
  header.label_bytes = text.size();
  header.checksum = snapshot_checksum(header, behind);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

// The checksum finds accidents, not bytes that were made up. So indices and pins must have
// values that an episode can have. Other columns may hold any value: at worst it ends the episode.
void check_content(const BatchData& data, std::span<const std::byte> row) {
  for (const ColumnStore* store : {&data.memory, &data.pin_memory, &data.outputs}) {
    const ColumnView bad = store->find_beyond_limits(row);
    if (bad.field != nullptr) {
      refuse("'" + bad.field->name + "' has a value that no episode of " + data.info().id + " has");
    }
    if (store == &data.pin_memory) data.pins.check_saved(row);
    row = row.subspan(store->row_bytes());
  }
}

// Throws Error unless the bytes are `count` environments that fit this batch.
void check(const BatchData& data, std::span<const std::byte> bytes, int count) {
  const Header header = read_header(bytes);
  const std::span<const std::byte> behind = bytes.subspan(sizeof header);
  const std::string own = label_of(data);
  const std::string given(reinterpret_cast<const char*>(behind.data()),
                          std::min<std::size_t>(header.label_bytes, behind.size()));
  if (given != own) refuse("it is of " + given + "; this batch is of " + own);
  if (header.columns != columns_of(data)) {
    refuse("it is of another build of engram, with other columns of " + own);
  }
  if (header.num_envs != static_cast<std::uint32_t>(count)) {
    refuse(std::to_string(header.num_envs) + " environments given, " + std::to_string(count) +
           " needed");
  }
  const std::size_t content = behind.size() - own.size();
  const std::size_t needed = at(count) * row_bytes_of(data);
  if (content != needed) {
    refuse(std::to_string(content) + " bytes of content given, " + std::to_string(needed) +
           " needed");
  }
  for (int i = 0; i < count; ++i) {
    check_content(data,
                  behind.subspan(own.size() + at(i) * row_bytes_of(data), row_bytes_of(data)));
  }
}

void restore_range(BatchData& data, Range envs, std::span<const std::byte> bytes) {
  const int count = envs.end - envs.begin;
  std::span<const std::byte> rest = bytes.last(at(count) * row_bytes_of(data));
  const Column<float>& observation = data.observation;
  for (int env = envs.begin; env < envs.end; ++env) {
    for (ColumnStore* store : {&data.memory, &data.pin_memory, &data.outputs}) {
      store->load_row(env, rest);
      rest = rest.subspan(store->row_bytes());
    }
    data.final_mask[at(env)] = 0;
    // The snapshot may be of a batch with other observations; this batch makes its own.
    std::fill_n(observation.row(env), observation.width(), 0.0F);
  }
  data.observe(envs);
  for (int env = envs.begin; env < envs.end; ++env) data.render(0, env);
  data.copy_outputs(envs);
}

// Precedes the snapshots of several tasks, each behind its length.
constexpr char kMagicOfTasks[8] = {'e', 'n', 'g', 'r', 'a', 'm', 's', 'g'};

void append(std::vector<std::byte>& bytes, std::span<const std::byte> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

void append(std::vector<std::byte>& bytes, std::uint64_t number) {
  append(bytes, std::as_bytes(std::span(&number, 1)));
}

// The snapshots of `count` tasks. Throws Error if the bytes are of something else.
std::vector<std::span<const std::byte>> split(std::span<const std::byte> bytes, int count) {
  const auto number = [&] {
    std::uint64_t value = 0;
    if (bytes.size() < sizeof value) refuse("its end is missing");
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes = bytes.subspan(sizeof value);
    return value;
  };
  constexpr std::size_t kSize = sizeof kMagicOfTasks;
  if (bytes.size() < kSize || std::memcmp(bytes.data(), kMagicOfTasks, kSize) != 0) {
    refuse("not of a group of tasks");
  }
  bytes = bytes.subspan(kSize);
  const std::uint64_t given = number();
  if (given != static_cast<std::uint64_t>(count)) {
    refuse(std::to_string(given) + " tasks given, " + std::to_string(count) + " needed");
  }
  std::vector<std::span<const std::byte>> parts;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t size = number();
    if (size > bytes.size()) refuse("its end is missing");
    parts.push_back(bytes.first(size));
    bytes = bytes.subspan(size);
  }
  if (!bytes.empty()) refuse(std::to_string(bytes.size()) + " bytes too many");
  return parts;
}

BatchData& part_of(const Batch& batch, int part) { return BatchAccess::data(batch.part(part)); }

}  // namespace

std::vector<std::byte> Snapshotter::save(int env) const {
  const auto [part, own] = batch_.locate(env);
  return save_range(part_of(batch_, part), {own, own + 1});
}

std::size_t Snapshotter::save_size(int env) const {
  return size_of(part_of(batch_, batch_.locate(env).first), 1);
}

std::vector<std::byte> Snapshotter::save() const {
  if (!batch_.is_common()) return save_range(part_of(batch_, 0), {0, batch_.num_envs()});
  std::vector<std::byte> bytes;
  append(bytes, std::as_bytes(std::span(kMagicOfTasks)));
  append(bytes, static_cast<std::uint64_t>(batch_.num_parts()));
  for (int i = 0; i < batch_.num_parts(); ++i) {
    const BatchData& data = part_of(batch_, i);
    append(bytes, size_of(data, data.num_envs()));
    append(bytes, save_range(data, {0, data.num_envs()}));
  }
  return bytes;
}

std::size_t Snapshotter::save_size() const {
  if (!batch_.is_common()) return size_of(part_of(batch_, 0), batch_.num_envs());
  std::size_t size = sizeof kMagicOfTasks + sizeof(std::uint64_t);
  for (int i = 0; i < batch_.num_parts(); ++i) {
    const BatchData& data = part_of(batch_, i);
    size += sizeof(std::uint64_t) + size_of(data, data.num_envs());
  }
  return size;
}

void Snapshotter::restore(int env, std::span<const std::byte> bytes) const {
  const IeeeScope scope;
  const auto [part, own] = batch_.locate(env);
  BatchData& data = part_of(batch_, part);
  data.require_started("restore");
  check(data, bytes, 1);
  restore_range(data, {own, own + 1}, bytes);
}

void Snapshotter::restore(std::span<const std::byte> bytes) const {
  const IeeeScope scope;
  const std::vector<std::span<const std::byte>> saved =
      batch_.is_common() ? split(bytes, batch_.num_parts()) : std::vector{bytes};
  for (int i = 0; i < batch_.num_parts(); ++i) {
    const BatchData& data = part_of(batch_, i);
    check(data, saved[at(i)], data.num_envs());
  }
  for (int i = 0; i < batch_.num_parts(); ++i) {
    BatchData& data = part_of(batch_, i);
    restore_range(data, {0, data.num_envs()}, saved[at(i)]);
    data.started = true;
    data.interrupted = false;
  }
}

}  // namespace engram
