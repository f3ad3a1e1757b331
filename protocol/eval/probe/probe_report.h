// What probes have found, as one HTML page and as files.
#pragma once

#include <filesystem>
#include <string>

#include "protocol/io/json.h"

namespace engram {

// A share with its interval, "0.940 [0.838, 0.979]"; "-" if there is none.
std::string share_text(const Json& share);

// A page of one policy. document: of run_probes.
std::string probe_report(const Json& document);

// Writes probe.json and probe.html into the folder, which is made if need be. Throws Error (kIo) if
// that fails.
void write_probes(const Json& document, const std::filesystem::path& folder);

}  // namespace engram
