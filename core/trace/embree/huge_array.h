// An array of plain data on large pages: rays touch surfels at random, and with small pages half of the time goes into looking
// up where a page is. Content is not kept or cleared when it is sized anew.
#pragma once

#include <sys/mman.h>

#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace vitrine::embree {

template <class T>
class HugeArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  void resize(size_t size) {
    if (size > capacity_) {
      const size_t bytes = (size * sizeof(T) + kPage - 1) / kPage * kPage;
      data_.reset(static_cast<T*>(std::aligned_alloc(kPage, bytes)));
      if (!data_) throw std::bad_alloc();
      madvise(data_.get(), bytes, MADV_HUGEPAGE);  // a wish: where the system has none, the small ones do
      capacity_ = bytes / sizeof(T);
    }
    size_ = size;
  }
  size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }

 private:
  static constexpr size_t kPage = 2 << 20;
  struct Free {
    void operator()(T* p) const { std::free(p); }
  };
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0, capacity_ = 0;
};

}  // namespace vitrine::embree
