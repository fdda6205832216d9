#include "bench/operator/lending_model.h"

#include <algorithm>
#include <string>

namespace diaphane::fleet::bench {
namespace {

constexpr std::size_t kAtRandom = 16;  // as in capacity_broker.cpp
constexpr int kRounds = 6;             // of distribution; one more moves less than a thousandth

std::size_t number(const std::string& id) { return static_cast<std::size_t>(std::stoul(id)); }

}  // namespace

PeerLoad LendingModel::observed(const Device& device, std::size_t number) const {
  PeerLoad one;
  one.id = std::to_string(number);
  one.load = said_[number].load;
  one.lent = said_[number].lent;
  one.age = 1;
  one.draining = device.draining;
  return one;
}

void LendingModel::decide(const std::vector<Device>& devices) {
  helpers_ = begun_ = 0;
  LendingInput input;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (!devices[i].there) {
      lendings_[i] = {};
      continue;
    }
    // A device whose own time suffices and that has no helpers asks none, unless it may have spare
    // time.
    const bool needs = devices[i].wants >= rules_.borrows;
    const bool takes = rules_.most_spare > 0 && devices[i].wants >= rules_.renders;
    if (!needs && !takes && lendings_[i].helpers.empty()) continue;
    input.asked = devices[i].wants;
    input.helped = helped_[i];
    input.peers.clear();
    std::vector<std::size_t> known;
    for (std::size_t k = 0; k < kAtRandom; ++k) known.push_back(random_.below(devices.size()));
    for (const Helper& helper : lendings_[i].helpers) known.push_back(number(helper.id));
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    for (const std::size_t other : known) {
      if (other != i && devices[other].there) {
        input.peers.push_back(observed(devices[other], other));
      }
    }
    lendings_[i] = lend(std::move(lendings_[i]), input, rules_, random_.bits());
    helpers_ += lendings_[i].helpers.size();
    for (const Helper& helper : lendings_[i].helpers) begun_ += helper.since == 0;
  }
}

void LendingModel::share_out(const std::vector<Device>& devices) {
  struct Link {
    std::size_t from, to;
    double wanted = 0;
  };
  std::vector<Link> links;
  std::vector<double> lacks(devices.size()), left(devices.size()), given(devices.size());
  const double of_use = 1 - costs_.handing - costs_.merging;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    lacks[i] = std::max(0.0, devices[i].wants - 1) / of_use;
    left[i] = std::max(0.0, 1 - devices[i].wants);
    for (const Helper& helper : lendings_[i].helpers) {
      if (!helper.spare && helper.since >= costs_.load_seconds)
        links.push_back({number(helper.id), i});
    }
  }
  std::vector<double> taken(devices.size());
  std::vector<int> open(devices.size());
  std::vector<double> wanted(devices.size());
  // A device that lacks time asks its helpers for equal parts. A helper that is asked for more than
  // it has left serves every request in the same proportion.
  for (int round = 0; round < kRounds; ++round) {
    std::fill(open.begin(), open.end(), 0);
    std::fill(wanted.begin(), wanted.end(), 0.0);
    for (const Link& link : links) open[link.to] += left[link.from] > 0;
    for (Link& link : links) {
      link.wanted = left[link.from] > 0 ? lacks[link.to] / open[link.to] : 0;
      wanted[link.from] += link.wanted;
    }
    std::vector<double> scale(devices.size());
    for (std::size_t i = 0; i < devices.size(); ++i) {
      scale[i] = wanted[i] > 0 ? std::min(1.0, left[i] / wanted[i]) : 0;
    }
    for (const Link& link : links) {
      const double gets = link.wanted * scale[link.from];
      given[link.from] += gets;
      left[link.from] = std::max(0.0, left[link.from] - gets);
      taken[link.to] += gets;
      lacks[link.to] = std::max(0.0, lacks[link.to] - gets);
    }
  }
  lent_ = 0;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    said_[i] = {std::min(1.0, devices[i].wants), given[i]};
    helped_[i] = taken[i] * of_use;
    loads_[i] = devices[i].wants - taken[i] * of_use + given[i];
    lent_ += given[i];
  }
  share_out_spare(devices, left);
}

void LendingModel::share_out_spare(const std::vector<Device>& devices,
                                   const std::vector<double>& left) {
  const auto takes = [&](std::size_t device, const Helper& helper) {
    return helper.spare && helper.since >= costs_.load_seconds && devices[device].wants > 0;
  };
  std::vector<int> takers(devices.size());
  for (std::size_t i = 0; i < devices.size(); ++i) {
    for (const Helper& helper : lendings_[i].helpers) {
      takers[number(helper.id)] += takes(i, helper);
    }
  }
  for (std::size_t i = 0; i < devices.size(); ++i) {
    spare_[i].clear();
    for (const Helper& helper : lendings_[i].helpers) {
      if (!takes(i, helper)) continue;
      spare_[i].push_back(left[number(helper.id)] / takers[number(helper.id)]);
    }
  }
}

void LendingModel::step(const std::vector<Device>& devices) {
  lendings_.resize(devices.size());
  said_.resize(devices.size());
  helped_.resize(devices.size());
  loads_.resize(devices.size());
  spare_.resize(devices.size());
  decide(devices);
  share_out(devices);
}

}  // namespace diaphane::fleet::bench
