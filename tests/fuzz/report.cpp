// Any bytes as the report of a child, which may be compromised.
#include "ingest/pipeline/report.h"

#include "tests/fuzz/must.h"
#include "volume/header.h"

using namespace diaphane;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const auto verdict = ingest::read_report({reinterpret_cast<const char*>(data), size});
  if (!verdict) return 0;
  if (verdict->ready) {
    MUST(volume::check(verdict->header).has_value());
    MUST(verdict->header.repairs.size() <= 20);
  } else {
    MUST(!verdict->code.empty() && verdict->code.size() <= 40 && verdict->text.size() <= 400);
  }
  MUST(ingest::read_report(ingest::write_report(*verdict)).has_value());
  return 0;
}
