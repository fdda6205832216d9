#include "bench/schedule/figure9.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bench/renderer/text.h"

namespace diaphane::render::bench {
namespace {

constexpr std::size_t kTurns = 15;
constexpr int kSnapshots = 4000;

std::vector<Situation::Turn> snapshot(std::vector<std::uint64_t> n, Policy& policy) {
  std::vector<SessionView> views(n.size());
  for (std::size_t i = 0; i < n.size(); ++i) {
    views[i].session = i + 1;
    views[i].seconds_per_sample = 0.02;
    views[i].seconds_since_input = 1;
  }
  std::vector<Situation::Turn> turns;
  while (turns.size() < kTurns) {
    for (std::size_t i = 0; i < n.size(); ++i) {
      views[i].samples = n[i];
      views[i].error = 1 / std::sqrt(double(n[i]));
    }
    const std::uint64_t node = policy.next(views).at(0).session;
    turns.push_back({static_cast<std::size_t>(node), ++n[node - 1]});
  }
  return turns;
}

}  // namespace

std::vector<Situation> figure9(std::uint64_t seed) {
  std::vector<Situation> situations{
      {"2 nodes: 1 interacts, 2 rests", {1, 850}, {}, {}, {}},
      {"2 nodes: 1 interacts, 2 rests longer", {6, 2258}, {}, {}, {}},
      {"2 nodes: both interact", {15, 77}, {}, {}, {}},
      {"4 nodes: 1 interacts, 2 to 4 rest", {3, 807, 681, 1023}, {}, {}, {}},
      {"4 nodes: all were touched lately", {6, 50, 30, 73}, {}, {}, {}},
      {"4 nodes: 1 interacts, 2 to 4 rest longer", {9, 2688, 2596, 2600}, {}, {}, {}},
      {"4 nodes: all interact all the time", {30, 18, 16, 41}, {}, {}, {}},
  };
  // One iteration per turn.
  QuantumLimits limits;
  limits.max_samples = 1;
  const auto policy = make_policy(PolicyKind::kErrorProportional, limits, seed);
  for (Situation& situation : situations) {
    situation.turns = snapshot(situation.iterations, *policy);
    situation.shares.assign(situation.iterations.size(), 0);
    for (int i = 0; i < kSnapshots; ++i) {
      for (const auto& turn : snapshot(situation.iterations, *policy)) {
        situation.shares[turn.node - 1] += 1.0 / (kSnapshots * kTurns);
      }
    }
    for (const std::uint64_t n : situation.iterations) {
      situation.expected.push_back(1 / std::sqrt(double(n)));
    }
    const double all = std::accumulate(situation.expected.begin(), situation.expected.end(), 0.0);
    for (double& share : situation.expected) share /= all;
  }
  return situations;
}

std::string figure9_text(const std::vector<Situation>& situations) {
  std::string text = "thesis, Figure 9: node and its iteration, one turn a line\n";
  for (std::size_t i = 0; i < situations.size(); ++i) {
    print(text, "  %zu: %s\n", i + 1, situations[i].what.c_str());
  }
  for (std::size_t i = 0; i < situations.size(); ++i) print(text, "%9zu ", i + 1);
  text += '\n';
  for (std::size_t turn = 0; turn < kTurns; ++turn) {
    for (const Situation& s : situations) {
      print(text, "%4zu %4llu ", s.turns[turn].node,
            static_cast<unsigned long long>(s.turns[turn].iteration));
    }
    text += '\n';
  }
  text += "share of the turns, over 4000 snapshots (in brackets: 1/sqrt(n) at their begin)\n";
  for (std::size_t i = 0; i < situations.size(); ++i) {
    print(text, "  %zu:", i + 1);
    for (std::size_t node = 0; node < situations[i].shares.size(); ++node) {
      print(text, "  node %zu %.3f (%.3f)", node + 1, situations[i].shares[node],
            situations[i].expected[node]);
    }
    text += '\n';
  }
  return text;
}

std::string figure9_json(const std::vector<Situation>& situations) {
  auto list = nlohmann::ordered_json::array();
  for (const Situation& s : situations) {
    auto turns = nlohmann::json::array();
    for (const auto& turn : s.turns) turns.push_back({turn.node, turn.iteration});
    list.push_back({{"what", s.what},
                    {"begin", s.iterations},
                    {"turns", std::move(turns)},
                    {"shares", s.shares},
                    {"expected", s.expected}});
  }
  return list.dump(1) + "\n";
}

}  // namespace diaphane::render::bench
