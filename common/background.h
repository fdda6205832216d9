#pragma once

/// The CPU priority and cores of work that nobody waits for.
namespace diaphane::background {

/// Limits all threads that call enter() afterwards to the first `cores` of the cores that this
/// process may use, so that the others stay free for work that somebody waits for: on a busy core,
/// Linux may delay a thread by several of its 4 ms ticks, even behind one with a lower priority. 0
/// removes the limit.
void limit_cores(unsigned cores);

/// Sets the nice value of the calling thread (0 to 19) and applies the limit of limit_cores().
/// Threads that it starts inherit both. Has no effect where the system does not permit it.
void enter(int nice);

}  // namespace diaphane::background
