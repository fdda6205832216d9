#pragma once

namespace diaphane::ingest {

/// Makes the process exit at once with `exit_code` when `new` fails although the process's own
/// limit (RLIMIT_AS) leaves room. Then the machine has too little memory and the input is not at
/// fault, so no library may report the failure as damaged input. Linking this replaces the global
/// operator new. Has no effect under a sanitizer, which has its own operator new.
void end_when_machine_is_short_of_memory(int exit_code);

}  // namespace diaphane::ingest
