#include "protocol/io/bytes.h"

namespace engram {

// Not in the header: inlined, it makes GCC 12 see overflows that are not there.
void ByteWriter::append(std::span<const std::byte> bytes) {
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

}  // namespace engram
