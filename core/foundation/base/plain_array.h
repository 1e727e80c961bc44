// Uninitialised SIMD-aligned array of trivial types. Resizing neither keeps nor clears the content; render passes reuse their
// arrays between steps.
#pragma once

#include <sys/mman.h>

#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

namespace vitrine {

// Huge pages are for random access: with small pages half of the time is TLB misses.
enum class Pages { Small, Huge };

template <class T, Pages kPages = Pages::Small>
class PlainArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  void resize(size_t size) {
    if (size > capacity_) {
      const size_t wanted = kPages == Pages::Huge ? size : size + size / 4;
      const size_t bytes = (wanted * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
      data_.reset(static_cast<T*>(std::aligned_alloc(kAlignment, bytes)));
      if (!data_) throw std::bad_alloc();
      if (kPages == Pages::Huge) madvise(data_.get(), bytes, MADV_HUGEPAGE);  // a hint; without support small pages are used
      capacity_ = bytes / sizeof(T);
    }
    size_ = size;
  }
  size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }
  std::span<T> span() { return {data(), size_}; }

 private:
  static constexpr size_t kAlignment = kPages == Pages::Huge ? 2 << 20 : 64;
  struct Free {
    void operator()(T* p) const { std::free(p); }
  };
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0, capacity_ = 0;
};

}  // namespace vitrine
