#include "operator/observe/snapshot.h"

#include <gtest/gtest.h>

#include "operator/plan/random.h"

namespace diaphane::fleet {
namespace {

struct Stores {
  kube::Store<FleetObject> fleets;
  kube::Store<WorkerObject> workers;
  kube::Store<PodObject> pods;
  kube::Store<NodeObject> nodes;
  Observer observer() const { return {fleets, workers, pods, nodes}; }
};

class ObserverTest : public testing::Test {
 protected:
  std::string next() { return std::to_string(++version_); }
  FleetObject fleet(const std::string& name) {
    FleetObject one;
    one.name = one.fleet.name = name;
    one.uid = one.fleet.uid = "u-" + name;
    one.version = one.fleet.version = next();
    one.pods = std::make_shared<const Json>(name);
    return one;
  }
  WorkerObject worker(const std::string& name, const std::string& node) {
    WorkerObject one;
    one.name = one.worker.name = name;
    one.uid = one.worker.uid = "u-" + name;
    one.version = one.worker.version = next();
    one.worker.node = node;
    one.pods = std::make_shared<const Json>(name);
    return one;
  }
  PodObject pod(const std::string& name, const std::string& node, int foreign) {
    PodObject one;
    one.name = one.pod.name = name;
    one.version = one.pod.version = next();
    one.pod.node = node;
    one.ours = foreign == 0;
    one.gpus = foreign;
    return one;
  }
  NodeObject node(const std::string& name, int gpus) {
    NodeObject one;
    one.name = one.node.name = name;
    one.version = next();
    one.node.gpus = gpus;
    return one;
  }

  int version_ = 0;
  Stores stores_;
};

void expect_same(const Snapshot& a, const Snapshot& b) {
  EXPECT_EQ(a.world.fleets, b.world.fleets);
  EXPECT_EQ(a.world.workers, b.world.workers);
  EXPECT_EQ(a.world.pods, b.world.pods);
  EXPECT_EQ(a.world.nodes, b.world.nodes);
  EXPECT_EQ(a.pods_of, b.pods_of);
  EXPECT_EQ(a.index, b.index);
}

TEST_F(ObserverTest, IncrementalViewEqualsFullRebuild) {
  Random random(7);
  const auto some = [&](const char* kind) { return kind + std::to_string(random.below(6)); };
  Observer kept = stores_.observer();
  for (int step = 0; step < 2000; ++step) {
    const std::string at = some("n");
    switch (random.below(9)) {
      case 0:
        stores_.fleets.changed(fleet(some("f")));
        break;
      case 1:
        stores_.workers.changed(worker(some("w"), at));
        break;
      case 2:
        stores_.pods.changed(pod(some("w"), at, 0));
        break;
      case 3:
        stores_.pods.changed(pod(some("x"), at, 1 + static_cast<int>(random.below(3))));
        break;
      case 4:
        stores_.nodes.changed(node(at, static_cast<int>(random.below(9))));
        break;
      case 5:
        stores_.fleets.deleted(some("f"), next());
        break;
      case 6:
        stores_.workers.deleted(some("w"), next());
        break;
      case 7:
        stores_.pods.deleted(some(random.below(2) == 0 ? "w" : "x"), next());
        break;
      default:
        stores_.nodes.deleted(at, next());
    }
    if (random.below(3) == 0) continue;  // sometimes several changes at once
    expect_same(kept.snapshot(step), stores_.observer().snapshot(step));
    ASSERT_FALSE(HasFailure()) << "step " << step;
  }
}

TEST_F(ObserverTest, CopiesNothingWhileNothingChanges) {
  stores_.workers.changed(worker("w", "n"));
  Observer kept = stores_.observer();
  const char* before = kept.snapshot(1).world.workers[0].uid.data();
  kept.snapshot(1).world.workers[0].uid += "!";  // would be lost if it were copied again
  stores_.nodes.changed(node("n", 8));
  EXPECT_EQ(kept.snapshot(2).world.workers[0].uid, "u-w!");
  EXPECT_EQ(kept.snapshot(2).world.workers[0].uid.data(), before);
  EXPECT_EQ(kept.snapshot(2).world.nodes.size(), 1U);
  EXPECT_EQ(kept.snapshot(3).world.now, 3);
  stores_.workers.changed(worker("w", "n"));
  EXPECT_EQ(kept.snapshot(4).world.workers[0].uid, "u-w");
}

TEST_F(ObserverTest, CountsForeignGpusOnNodesThatAppearLater) {
  Observer kept = stores_.observer();
  stores_.pods.changed(pod("x", "n", 3));
  EXPECT_TRUE(kept.snapshot(1).world.nodes.empty());
  stores_.nodes.changed(node("n", 8));
  EXPECT_EQ(kept.snapshot(2).world.nodes[0].foreign_gpus, 3);
  stores_.pods.deleted("x", next());
  EXPECT_EQ(kept.snapshot(3).world.nodes[0].foreign_gpus, 0);
}

TEST_F(ObserverTest, ReportsOnlyRelevantChanges) {
  EXPECT_TRUE(stores_.workers.changed(worker("w", "n")));
  EXPECT_FALSE(stores_.workers.changed(*stores_.workers.find("w"))) << "told twice";
  WorkerObject again = *stores_.workers.find("w");
  again.version = again.worker.version = next();
  EXPECT_FALSE(stores_.workers.changed(again)) << "another version, and nothing else";
  EXPECT_EQ(stores_.workers.find("w")->version, again.version);
  EXPECT_TRUE(stores_.workers.changed(worker("w", "m")));
  EXPECT_TRUE(stores_.nodes.changed(node("n", 8)));
  EXPECT_FALSE(stores_.nodes.changed(node("n", 8))) << "a heartbeat";
  EXPECT_TRUE(stores_.nodes.changed(node("n", 7)));
  EXPECT_TRUE(stores_.pods.changed(pod("p", "n", 0)));
  EXPECT_FALSE(stores_.pods.changed(pod("p", "n", 0)));
  EXPECT_TRUE(stores_.pods.deleted("p", next()));
  EXPECT_FALSE(stores_.pods.deleted("p", next()));
  EXPECT_TRUE(stores_.fleets.changed(fleet("f")));
  EXPECT_FALSE(stores_.fleets.changed(fleet("f"))) << "the same template, read again";
}

}  // namespace
}  // namespace diaphane::fleet
