#include "protocol/io/journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "core/base/temporary_file.h"
#include "protocol/io/chained_hash.h"
#include "protocol/io/json_values.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "engram journal 1\n";
constexpr std::size_t kFrame = sizeof(std::uint32_t) + sizeof(std::uint64_t);

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw Error(Error::kIo, "'" + file.string() + "' " + what);
}

// A record: length, hash of the record with the one before as its seed, content.
Bytes framed(std::uint64_t chain, const Bytes& content) {
  ByteWriter out;
  out.put(static_cast<std::uint32_t>(content.size()));
  out.put(chain_hash(chain, std::span<const std::byte>(content)));
  out.append(std::span<const std::byte>(content));
  return out.take();
}

// The content of the record that comes next; nothing if it is not whole.
std::optional<std::span<const std::byte>> take_record(std::span<const std::byte>& rest,
                                                      std::uint64_t& chain) {
  if (rest.size() < kFrame) return std::nullopt;
  ByteReader in(rest);
  const auto size = in.get<std::uint32_t>();
  const auto hash = in.get<std::uint64_t>();
  if (size > in.rest().size()) return std::nullopt;
  const std::span<const std::byte> content = in.take(size);
  if (chain_hash(chain, content) != hash) return std::nullopt;
  chain = hash;
  rest = in.rest();
  return content;
}

std::int64_t milliseconds_now() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

Bytes to_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::optional<JournalContent> read_journal(const OpenFolder& folder) {
  const std::optional<std::string> text = folder.read_file(kJournalFile);
  if (!text) return std::nullopt;
  const fs::path file = folder.path() / kJournalFile;
  if (!text->starts_with(kMagic)) fail(file, "is not a journal of this engram's; remove it");
  JournalContent journal;
  std::span<const std::byte> rest = std::as_bytes(std::span(*text)).subspan(kMagic.size());
  const auto header = take_record(rest, journal.chain);
  std::optional<Json> document;
  if (header) {
    document = parse_json({reinterpret_cast<const char*>(header->data()), header->size()});
  }
  if (!document || !is_table(*document)) {
    fail(file, "is damaged at its beginning; remove it to play its episodes again");
  }
  journal.header = *std::move(document);
  while (const auto record = take_record(rest, journal.chain)) {
    ByteReader in(*record);
    const std::string task = in.text();
    const auto episode = in.get<std::int32_t>();
    journal.records[task][episode] = {in.rest().begin(), in.rest().end()};
  }
  journal.size = text->size() - rest.size();
  return journal;
}

Journal::Journal(const OpenFolder& folder, const JsonTable& header) : folder_(folder) {
  std::optional<JournalContent> before = read_journal(folder);
  if (before && !before->records.empty()) {
    const fs::path file = folder.path() / kJournalFile;
    // As it is read back.
    const Json now = parse_json(to_line(header)).value_or(Json());
    require_same_run(before->header, "'" + file.string() + "'", now, "this run");
    records_ = std::move(before->records);
    chain_ = before->chain;
    open(before->size);
    return;
  }
  const Bytes first = framed(0, to_bytes(to_line(header)));
  ByteWriter out;
  out.append(std::as_bytes(std::span(kMagic)));
  out.append(std::span<const std::byte>(first));
  folder.write_file(kJournalFile, std::span<const std::byte>(out.bytes()));
  std::span<const std::byte> rest(first);
  (void)take_record(rest, chain_);
  open(out.bytes().size());
}

Journal::~Journal() {
  if (descriptor_ < 0) return;
  ::fdatasync(descriptor_);
  ::close(descriptor_);
}

void Journal::open(std::size_t size) {
  constexpr int kAppend = O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC;
  bytes_ = static_cast<std::int64_t>(size);
  descriptor_ = ::openat(folder_.descriptor(), kJournalFile, kAppend);
  // Without the torn end of a process that was killed.
  if (descriptor_ >= 0 && ::ftruncate(descriptor_, bytes_) == 0) return;
  const int error = errno;
  if (descriptor_ >= 0) ::close(descriptor_);
  fail(folder_.path() / kJournalFile, std::string("cannot be written: ") + std::strerror(error));
}

std::size_t Journal::size() const {
  std::size_t count = 0;
  for (const auto& [task, episodes] : records_) count += episodes.size();
  return count;
}

void Journal::add(const JournalRecords& records) {
  for (const auto& [task, episodes] : records) {
    for (const auto& [episode, result] : episodes) add(task, episode, result);
  }
}

void Journal::add(std::string_view task, int episode, const Bytes& result) {
  ByteWriter content;
  content.put(task);
  content.put(static_cast<std::int32_t>(episode));
  content.append(std::span<const std::byte>(result));
  const Bytes record = framed(chain_, content.bytes());
  if (const int error = write_all(descriptor_, record); error != 0) {
    // Where that fails too, the next run drops the record.
    [[maybe_unused]] const int truncated = ::ftruncate(descriptor_, bytes_);
    fail(folder_.path() / kJournalFile, std::string("cannot be written: ") + std::strerror(error));
  }
  bytes_ += static_cast<std::int64_t>(record.size());
  std::memcpy(&chain_, record.data() + sizeof(std::uint32_t), sizeof chain_);
  records_[std::string(task)][episode] = result;
  // A killed process loses nothing; a power cut, the last second.
  const std::int64_t now = milliseconds_now();
  if (now - synced_ < 1000) return;
  synced_ = now;
  (void)::fdatasync(descriptor_);
}

void Journal::remove() { ::unlinkat(folder_.descriptor(), kJournalFile, 0); }

void require_same_run(const Json& before, const std::string& there, const Json& now,
                      const std::string& here) {
  const auto differing = [&](const std::string& key, const Json& first, const Json& second) {
    throw Error(Error::kInvalidArgument, there + " has " + key + " " + to_line(first) + ", " +
                                             here + " " + to_line(second) +
                                             "; one run has one of them");
  };
  if (!is_table(before) || !is_table(now)) {
    if (before != now) differing("run", before, now);
    return;
  }
  // Checksums differ wherever anything does.
  const auto compare = [&](const JsonTable& keys) {
    for (const auto& [key, unused] : keys) {
      const Json first = value_or_null(before, key);
      const Json second = value_or_null(now, key);
      if (key == "checksum" || key == "command" || first == second) continue;
      if (is_table(first) && is_table(second)) {
        require_same_run(first, there, second, here);
      } else {
        differing(key, first, second);
      }
    }
  };
  compare(table(now));
  compare(table(before));
}

}  // namespace engram
