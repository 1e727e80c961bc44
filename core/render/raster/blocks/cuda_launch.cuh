// Kernels of block_kernel.h on a CUDA device: the executor that stands for BlockLoops. One stream; arrays grow and are kept.
#pragma once

#include <cuda_runtime.h>

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <typeinfo>
#include <utility>

#include "core/render/raster/blocks/block_pass.h"

namespace vitrine::blocks {

inline void check_cuda(cudaError_t result, const char* what) {
  if (result != cudaSuccess) throw ExecutorFailure(std::string("CUDA: ") + what + ": " + cudaGetErrorString(result));
}

template <class Kernel>
__global__ __launch_bounds__(Kernel::kThreads) void run_kernel(const Kernel kernel) {
  __shared__ typename Kernel::Shared shared;
  typename Kernel::Thread thread;
  for (uint32_t phase = 0; kernel.has_phase(phase, shared); ++phase) {
    kernel.run(phase, {blockIdx.x, threadIdx.x}, thread, shared);
    __syncthreads();
  }
}

// Of all arrays of the process.
inline std::atomic<size_t>& device_bytes_held() {
  static std::atomic<size_t> bytes = 0;
  return bytes;
}

// Memory of the device; resizing keeps nothing.
template <class T>
class CudaArray {
 public:
  CudaArray() = default;
  CudaArray(const CudaArray&) = delete;
  CudaArray& operator=(const CudaArray&) = delete;
  CudaArray(CudaArray&& other) noexcept { *this = std::move(other); }
  CudaArray& operator=(CudaArray&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~CudaArray() { device_bytes_held() -= capacity_ * sizeof(T); }
  void resize(size_t size) {
    if (size > capacity_) {
      data_.reset();
      device_bytes_held() -= capacity_ * sizeof(T);
      capacity_ = 0;
      for (const size_t room : {size + size / 4, size}) {  // a fourth more than is needed, where there is so much
        void* data = nullptr;
        const cudaError_t result = cudaMalloc(&data, room * sizeof(T));
        if (result != cudaErrorMemoryAllocation) check_cuda(result, "no memory on the device");
        if (result != cudaSuccess) continue;
        data_.reset(static_cast<T*>(data));
        capacity_ = room;
        device_bytes_held() += room * sizeof(T);
        break;
      }
      cudaGetLastError();  // an allocation that failed is no error of the next kernel
      if (data_ == nullptr) {
        size_t free = 0, all = 0;
        check_cuda(cudaMemGetInfo(&free, &all), "no memory on the device");
        throw ExecutorMemory(size * sizeof(T), device_bytes_held(), free);
      }
    }
    size_ = size;
  }
  size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }

 private:
  struct Free {
    void operator()(T* data) const { cudaFree(data); }
  };
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0, capacity_ = 0;
};

// Name of a kernel without its namespaces, mangled.
template <class Kernel>
std::string kernel_name() {
  const std::string name = typeid(Kernel).name(), space = "6blocks";
  const size_t at = name.find(space);
  return at == name.npos ? name : name.substr(at + space.size());
}

class CudaLaunch {
 public:
  // kernel_ms: times of kernels by name are added there; null: none are measured.
  explicit CudaLaunch(std::map<std::string, double>* kernel_ms = nullptr) : kernel_ms_(kernel_ms) {}

  template <class T>
  using Array = CudaArray<T>;

  template <class Kernel>
  void launch(const Kernel& kernel, uint32_t blocks) {
    if (blocks == 0) return;
    cudaEvent_t begin = nullptr, end = nullptr;
    if (kernel_ms_ != nullptr) {
      check_cuda(cudaEventCreate(&begin), "no clock");
      check_cuda(cudaEventCreate(&end), "no clock");
      check_cuda(cudaEventRecord(begin), "no clock");
    }
    run_kernel<<<blocks, Kernel::kThreads>>>(kernel);
    check_cuda(cudaGetLastError(), "a kernel was not launched");
    if (kernel_ms_ == nullptr) return;
    float ms = 0;
    check_cuda(cudaEventRecord(end), "no clock");
    check_cuda(cudaEventSynchronize(end), "a kernel failed");
    check_cuda(cudaEventElapsedTime(&ms, begin, end), "no clock");
    (*kernel_ms_)[kernel_name<Kernel>()] += ms;
    cudaEventDestroy(begin);
    cudaEventDestroy(end);
  }
  // Of the device, bytes.
  size_t free_memory() const {
    size_t free = 0, all = 0;
    check_cuda(cudaMemGetInfo(&free, &all), "its memory is unknown");
    return free;
  }
  template <class T>
  T read(const T* value) const {
    T here;
    check_cuda(cudaMemcpy(&here, value, sizeof here, cudaMemcpyDeviceToHost), "a value was not read");
    return here;
  }
  template <class T>
  void upload(T* to, const T* from, size_t size) const {
    if (size > 0) check_cuda(cudaMemcpy(to, from, size * sizeof(T), cudaMemcpyHostToDevice), "values did not reach the device");
  }
  template <class T>
  void download(T* to, const T* from, size_t size) const {
    if (size > 0) check_cuda(cudaMemcpy(to, from, size * sizeof(T), cudaMemcpyDeviceToHost), "values did not come back");
  }

 private:
  std::map<std::string, double>* kernel_ms_;
};

}  // namespace vitrine::blocks
