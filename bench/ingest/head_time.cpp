// diaphane-head runs the head detection of ingestd on a stored volume and measures its time.
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/config.h"
#include "ingest/head/find_head.h"
#include "volume/volume.h"

namespace {

using namespace diaphane;

constexpr int kExitNoInput = 66;  // sysexits.h: EX_NOINPUT

constexpr const char* kUsage =
    "diaphane-head VOLUME...\n\n"
    "Detects for each stored volume whether it shows a head and which crop would remove the face.\n"
    "Prints one line of JSON per volume: {\"found\", \"sign\", \"proposal\", \"seconds\"}.\n\n"
    "Exit codes: 0 all volumes were processed, 64 bad command line, 66 cannot read a volume.\n";

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> positional(argv + 1, argv + argc);
  if (positional.empty() || positional.front().starts_with("-")) {
    const bool asked =
        !positional.empty() && (positional.front() == "--help" || positional.front() == "-h");
    std::fputs(kUsage, asked ? stdout : stderr);
    return asked ? 0 : kExitUsage;
  }
  for (const std::string& word : positional) {
    const auto volume = volume::read(word, false);
    if (!volume) {
      std::fprintf(stderr, "diaphane-head: %s: %s\n", word.c_str(), volume.error().message.c_str());
      return kExitNoInput;
    }
    const auto began = std::chrono::steady_clock::now();
    auto line = nlohmann::json::parse(ingest::to_json(ingest::find_head(*volume)));
    line["seconds"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    std::printf("%s\n", line.dump().c_str());
    std::fflush(stdout);
  }
  return 0;
}
