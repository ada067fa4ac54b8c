// Calls per second in processor time, the same for all programs that are compared.
#pragma once
#include <algorithm>
#include <ctime>

static double now() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

// Best rate [1/s] of some rounds, in processor time.
template <class F> static double rate(F f, size_t states) {
  double best = 0;
  for (int round = 0; round < 7; ++round) {
    size_t calls = 0;
    const double start = now();
    double end = start;
    while (end - start < 0.1) {
      for (size_t i = 0; i < states; ++i) f(i);
      calls += states;
      end = now();
    }
    best = std::max(best, calls / (end - start));
  }
  return best;
}
