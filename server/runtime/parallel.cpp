#include "server/runtime/parallel.h"

#include <ctime>

namespace lucerna {
namespace {
thread_local CpuMeter* current_meter = nullptr;
thread_local const SharedProcessors* shared_processors = nullptr;
}  // namespace

std::int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

SharedProcessors::SharedProcessors(const std::atomic<int>& running, int processors)
    : running_(running), processors_(processors), previous_(shared_processors) {
  shared_processors = this;
}
SharedProcessors::~SharedProcessors() { shared_processors = previous_; }

bool SharedProcessors::are_busy() {
  return shared_processors != nullptr &&
         shared_processors->running_.load(std::memory_order_relaxed) >=
             shared_processors->processors_;
}

CpuMeter::CpuMeter() : previous_(current_meter), start_ns_(thread_cpu_ns()) {
  current_meter = this;
}
CpuMeter::~CpuMeter() { current_meter = previous_; }

double CpuMeter::seconds() const {
  return 1e-9 * static_cast<double>(thread_cpu_ns() - start_ns_ + helpers_ns_.load());
}

CpuMeter* CpuMeter::current() { return current_meter; }

CpuMeter::Helping::Helping(CpuMeter* meter)
    : meter_(meter == current_meter ? nullptr : meter), previous_(current_meter) {
  if (meter_ == nullptr) return;
  current_meter = meter_;
  start_ns_ = thread_cpu_ns();
}

CpuMeter::Helping::~Helping() {
  if (meter_ == nullptr) return;
  meter_->helpers_ns_ += thread_cpu_ns() - start_ns_;
  current_meter = previous_;
}

}  // namespace lucerna
