// Content digests: 128-bit XXH3, printed as 32 hex digits. For cache keys and bit-exactness tests; not cryptographic.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace vitrine {

struct Digest {
  uint64_t high = 0, low = 0;
  std::string hex() const;        // 32 lower-case hex digits
  std::string short_hex() const;  // first 12 digits, for display
  bool operator==(const Digest&) const = default;
};

// Streaming hash. Each `add` includes its length, so that ("ab","c") and ("a","bc") differ.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;
  Hasher& add(std::string_view text);
  Hasher& add(std::span<const std::byte> bytes);
  Hasher& add(uint64_t value);
  Digest digest() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

Digest digest_bytes(std::string_view bytes);
Digest digest_file(const std::filesystem::path& path);  // throws Error{Input} if unreadable
// Digest of the names (relative, sorted by bytes) and contents of all regular files below `folder`.
Digest digest_folder(const std::filesystem::path& folder);

// SHA-256 (FIPS 180-4), 64 lower-case hex digits, as printed by `sha256sum`: the usual checksum of downloads. Much slower than
// XXH3; not for cache keys.
std::string sha256_hex(std::string_view bytes);

}  // namespace vitrine
