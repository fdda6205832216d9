#include "operator/plan/placing.h"

#include <algorithm>
#include <array>
#include <limits>

#include "operator/plan/parts.h"

namespace diaphane::fleet {
namespace {

constexpr std::array kReasons{
    "not ready",         "cordoned",          "not selected",      "tainted",
    "without telemetry", "rejected recently", "with too few GPUs", "full"};

bool tolerated(const Taint& taint, const std::vector<Toleration>& tolerations) {
  if (taint.effect != "NoSchedule" && taint.effect != "NoExecute") return true;
  return std::any_of(tolerations.begin(), tolerations.end(), [&](const Toleration& t) {
    return (t.key.empty() || t.key == taint.key) && (t.value.empty() || t.value == taint.value) &&
           (t.effect.empty() || t.effect == taint.effect);
  });
}

}  // namespace

std::optional<std::size_t> choose(std::span<const Candidate> candidates, Strategy strategy,
                                  Random& random) {
  if (strategy == Strategy::kPacked) {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Candidate& one = candidates[i];
      if (one.free <= 0) continue;
      if (!best || one.free < candidates[*best].free ||
          (one.free == candidates[*best].free && one.load < candidates[*best].load)) {
        best = i;
      }
    }
    return best;
  }
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& one : candidates) {
    if (one.free > 0) least = std::min(least, one.load);
  }
  const double most = least + kHysteresis * std::max(least, 1.0);
  std::size_t count = 0;
  for (const Candidate& one : candidates) count += one.free > 0 && one.load <= most;
  if (count == 0) return std::nullopt;
  std::size_t first = random.below(count), second = random.below(count);
  std::array<std::size_t, 2> drawn{};
  std::size_t number = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].free <= 0 || candidates[i].load > most) continue;
    if (number == first) drawn[0] = i;
    if (number == second) drawn[1] = i;
    ++number;
  }
  return candidates[drawn[1]].load < candidates[drawn[0]].load ? drawn[1] : drawn[0];
}

std::optional<Unfit> unfit(const NodeView& view, const FleetSpec& spec,
                           const std::vector<NodeBackoff>& refusals, Seconds now) {
  const Node& node = *view.node;
  for (const auto& [key, value] : spec.node_selector) {
    const auto found = node.labels.find(key);
    if (found == node.labels.end() || found->second != value) return Unfit::kSelector;
  }
  if (!node.ready) return Unfit::kNotReady;
  if (node.cordoned) return Unfit::kCordoned;
  for (const Taint& taint : node.taints) {
    if (!tolerated(taint, spec.tolerations)) return Unfit::kTaint;
  }
  if (out_of_service(node)) return Unfit::kTaint;
  if (node.gpus < spec.gpus_per_worker) return Unfit::kTooSmall;
  if (view.room(spec.gpus_per_worker) <= 0) return Unfit::kFull;
  if (view.silent) return Unfit::kSilent;
  for (const NodeBackoff& refusal : refusals) {
    if (refusal.node == node.name && now < refusal.since + backoff_of(refusal)) {
      return Unfit::kRefused;
    }
  }
  return std::nullopt;
}

Placing::Placing(const Fleet& fleet, const std::vector<NodeBackoff>& refusals,
                 std::vector<NodeView>& nodes, Seconds now)
    : nodes_(nodes), gpus_(fleet.spec.gpus_per_worker), unfit_(kReasons.size()) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto reason = unfit(nodes[i], fleet.spec, refusals, now);
    if (reason) {
      ++unfit_[static_cast<std::size_t>(*reason)];
      continue;
    }
    fit_.push_back(i);
    candidates_.push_back({nodes[i].load, nodes[i].room(gpus_)});
  }
  if (unfit_[static_cast<std::size_t>(Unfit::kRefused)] == 0) return;
  for (const NodeBackoff& refusal : refusals) {
    const Seconds due = refusal.since + backoff_of(refusal);
    if (due > now) again_ = std::min(again_.value_or(due), due);
  }
}

const std::string* Placing::next(Strategy strategy, Random& random) {
  const auto chosen = choose(candidates_, strategy, random);
  if (!chosen) return nullptr;
  Candidate& candidate = candidates_[*chosen];
  NodeView& node = nodes_[fit_[*chosen]];
  node.reserved += gpus_;
  node.load += static_cast<double>(gpus_) / node.node->gpus;
  candidate = {node.load, node.room(gpus_)};
  if (candidate.free <= 0) ++unfit_[static_cast<std::size_t>(Unfit::kFull)];
  return &node.node->name;
}

bool Placing::room() const {
  return std::any_of(candidates_.begin(), candidates_.end(),
                     [](const Candidate& one) { return one.free > 0; });
}

std::string Placing::why() const {
  std::string text = "0 of " + std::to_string(nodes_.size()) + " nodes have room";
  const char* between = ": ";
  for (std::size_t i = 0; i < kReasons.size(); ++i) {
    if (unfit_[i] == 0) continue;
    text += between + std::to_string(unfit_[i]) + " " + kReasons[i];
    between = ", ";
  }
  return text;
}

}  // namespace diaphane::fleet
