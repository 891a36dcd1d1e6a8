// A library to preload (LD_PRELOAD): counts what the haptic thread of a program allocates, releases
// and locks between its first and its last sleep, and prints one line on stderr at the end of the
// program. The haptic thread is the one with the name of HapticThread.

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <dlfcn.h>
#include <initializer_list>
#include <pthread.h>
#include <time.h>

namespace {

thread_local bool t_is_haptic = false;
std::atomic<unsigned long long> g_sleeps{0};

// Of the haptic thread. What it does before its first and after its last sleep is not reported.
struct Counter {
  std::atomic<unsigned long long> until_last_sleep{0};

  void count() {
    if (t_is_haptic) ++now_;
  }
  void sleep() {
    if (g_sleeps == 0) before_first_ = now_;
    until_last_sleep = now_ - before_first_;
  }

 private:
  unsigned long long now_ = 0;
  unsigned long long before_first_ = 0;
};
Counter g_allocations, g_releases, g_locks;

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

struct Report {
  ~Report() {
    std::fprintf(stderr,
                 "haptic thread: %llu allocations, %llu releases, %llu locks in %llu sleeps\n",
                 g_allocations.until_last_sleep.load(), g_releases.until_last_sleep.load(),
                 g_locks.until_last_sleep.load(), g_sleeps.load());
  }
} g_report;

}  // namespace

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  g_allocations.count();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  g_allocations.count();
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  g_allocations.count();
  return __libc_realloc(p, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  g_allocations.count();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return memalign(alignment, size);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t size) {
  *p = memalign(alignment, size);
  return *p == nullptr ? 12 /* ENOMEM */ : 0;
}
void free(void* p) {
  if (p != nullptr) g_releases.count();
  __libc_free(p);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static auto* const real = next<int(pthread_mutex_t*)>("pthread_mutex_lock");
  g_locks.count();
  return real(mutex);
}

int pthread_setname_np(pthread_t thread, const char* name) noexcept {
  static auto* const real = next<int(pthread_t, const char*)>("pthread_setname_np");
  if (::pthread_equal(thread, ::pthread_self()) && std::strcmp(name, "palpate-haptic") == 0) {
    t_is_haptic = true;
  }
  return real(thread, name);
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* time, timespec* left) {
  static auto* const real =
      next<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  if (t_is_haptic) {
    for (Counter* counter : {&g_allocations, &g_releases, &g_locks}) counter->sleep();
    ++g_sleeps;
  }
  return real(clock, flags, time, left);
}

}  // extern "C"
