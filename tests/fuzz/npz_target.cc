// Files of arrays: a ZIP archive of any bytes, read as a data set's file is; and, so that fuzzing
// gets behind the archive's checksums, members of any bytes in a sound archive.
#include <zip.h>

#include <array>

#include "protocol/datasets/npz.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

const std::filesystem::path& file() {
  static const Folder folder;
  static const std::filesystem::path path = folder.path() / "file.npz";
  return path;
}

void read_all() {
  const NpzFile npz(file());
  for (const char* name : {"reward", "rgb", "x"}) {
    for (const NpyType type : {NpyType::kFloat32, NpyType::kUint8, NpyType::kInt64}) {
      std::vector<std::int64_t> shape;
      if (!accepted([&] { shape = npz.shape(name, type); })) continue;
      accepted([&] { (void)npz.read(name, type, shape); });
      accepted([&] { (void)npz.scalar<std::int64_t>(name, NpyType::kInt64); });
    }
  }
}

// An archive with one stored member.
void put_archive(std::string_view member) {
  std::error_code ignored;
  std::filesystem::remove(file(), ignored);
  int code = 0;
  zip_t* archive = zip_open(file().c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  require(archive != nullptr, "no archive");
  zip_source_t* source = zip_source_buffer(archive, member.data(), member.size(), 0);
  const zip_int64_t index = zip_file_add(archive, "x.npy", source, 0);
  require(index == 0, "no member");
  zip_set_file_compression(archive, 0, ZIP_CM_STORE, 0);
  require(zip_close(archive) == 0, "archive not written");
}

}  // namespace

void fuzz_npz(Data data) {
  Input input(data);
  if (input.choice(2) == 0) {
    put_file(file(), input.rest_text());
  } else {
    put_archive(input.rest_text());
  }
  accepted([] { read_all(); });
  (void)code_points(input.rest_text());
}

}  // namespace engram::fuzz
