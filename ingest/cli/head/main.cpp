// diaphane-head: what ingestd says of a stored volume, "is there a head?", for measurements.
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
    "Says of each stored volume whether it shows a head and which cut would take the face: a line "
    "of JSON each,\n"
    "{\"found\", \"sign\", \"proposal\", \"seconds\"}.\n\n"
    "Exit: 0 all were looked at, 64 bad command line, 66 a volume cannot be read.\n";

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty() || words.front().starts_with("-")) {
    const bool asked = !words.empty() && (words.front() == "--help" || words.front() == "-h");
    std::fputs(kUsage, asked ? stdout : stderr);
    return asked ? 0 : kExitUsage;
  }
  for (const std::string& word : words) {
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
