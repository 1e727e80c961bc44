// Content digests: 128-bit XXH3, printed as 32 hex digits. Used for cache keys and for proving that two runs gave the same
// bytes; not a defence against an adversary.
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
  std::string short_hex() const;  // the first 12, for people
  bool operator==(const Digest&) const = default;
};

// Streaming hash. Every `add` is framed by its length, so that ("ab","c") and ("a","bc") differ.
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
Digest digest_file(const std::filesystem::path& path);  // throws Error{Input} when unreadable
// Names (relative, sorted by bytes) and contents of every regular file below `folder`.
Digest digest_folder(const std::filesystem::path& folder);

// SHA-256 (FIPS 180-4), 64 lower-case hex digits: the digest that people publish beside files for download, as `sha256sum` prints
// it. For cache keys the others are far quicker.
std::string sha256_hex(std::string_view bytes);

}  // namespace vitrine
