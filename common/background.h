#pragma once

/// The CPU priority of work that nobody waits for.
namespace diaphane::background {

/// Limits all threads that call enter() afterwards to the first `cores` of the cores that this
/// process may use, so that the others stay free for work that somebody waits for: on a busy core,
/// Linux may delay a thread by several of its 4 ms ticks, even behind one with a lower priority. 0
/// removes the limit.
void limit_cores(unsigned cores);

/// Gives the calling thread this nice value (0 to 19) and those cores. Threads that it starts
/// inherit both. Does nothing where the system does not permit it.
void enter(int nice);

}  // namespace diaphane::background
