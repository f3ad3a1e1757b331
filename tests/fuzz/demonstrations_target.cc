// A folder of demonstrations that a run continues: its metadata and its first file.
#include "protocol/datasets/demonstration_folder.h"
#include "protocol/datasets/npz.h"
#include "tests/fuzz/input.h"

namespace engram::fuzz {
namespace {

// A data file with arrays of any type, shape and content under the names that are read.
std::vector<std::byte> data_file(Input& input) {
  constexpr const char* kNames[] = {"episode_seed", "episode_length", "reward", "rgb"};
  constexpr NpyType kTypes[] = {NpyType::kInt64, NpyType::kInt32, NpyType::kFloat32,
                                NpyType::kUint8};
  constexpr std::size_t kSizes[] = {8, 4, 4, 1};
  std::vector<NpyArray> arrays;
  std::vector<std::vector<std::byte>> contents(4);
  for (std::size_t i = 0; i < 4; ++i) {
    const int form = input.choice(8);
    if (form == 7) continue;
    const std::size_t type = form == 6 ? static_cast<std::size_t>(input.choice(4)) : i;
    NpyArray array{kNames[i], kTypes[type], {}, {}};
    std::size_t count = 1;
    if (i >= 2 || form == 5) {
      count = static_cast<std::size_t>(input.choice(8));
      array.shape = {static_cast<std::int64_t>(count)};
    }
    if (form == 4) array.shape.push_back(input.take<std::int64_t>());  // does not fit the content
    contents[i].resize(count * kSizes[type]);
    const Data bytes = input.take_bytes(contents[i].size());
    if (!bytes.empty()) std::memcpy(contents[i].data(), bytes.data(), bytes.size());
    array.data = contents[i];
    arrays.push_back(std::move(array));
  }
  return arrays.empty() ? std::vector<std::byte>() : npz_bytes(arrays);
}

}  // namespace

void fuzz_demonstrations(Data data) {
  static const Folder root;
  const RegistryEntry& entry = require_entry("RememberColor3-VLA-v0");
  const std::filesystem::path folder = root.path() / "data_npz" / entry.id;
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  Input input(data);
  const std::vector<std::byte> file = data_file(input);
  put_file(folder / "train_data_0.npz", {reinterpret_cast<const char*>(file.data()), file.size()});
  if (input.choice(2) == 0) {
    std::filesystem::remove(folder / "metadata.json", ignored);
  } else {
    put_file(folder / "metadata.json", input.rest_text());
  }
  accepted([&] {
    const DemonstrationFolder found(root.path(), entry, {.episodes = 3, .max_attempts = 9});
    (void)to_text(found.metadata());
    (void)found.finished();
    require(found.steps() >= 0 && found.attempts() >= found.attempts_kept(), "impossible counts");
  });
}

}  // namespace engram::fuzz
