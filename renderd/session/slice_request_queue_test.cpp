#include "renderd/session/slice_request_queue.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <utility>

namespace diaphane::render {
namespace {

struct SliceRequestQueueTest : testing::Test {
  SliceRequestQueueTest() {
    header.size = {30, 20, 10};
    stacks = stacks_of(header);
  }
  static v1::SliceRequest request_of(
      std::initializer_list<std::pair<v1::AnatomicalPlane, std::uint32_t>> at,
      std::uint64_t taken = 0) {
    v1::SliceRequest message;
    for (const auto& [plane, index] : at) {
      message.add_slices()->set_plane(plane);
      message.mutable_slices()->rbegin()->set_index(index);
    }
    message.set_taken(taken);
    return message;
  }
  // Returns plane and index of the slice sent now, or (9, 9) for none.
  std::pair<std::size_t, std::uint32_t> sent() {
    const auto due = queue.take();
    if (!due) return {9, 9};
    queue.depart();
    return {due->plane, due->index};
  }

  volume::Header header;
  SliceStacks stacks;
  SliceRequestQueue queue;
};

using Leaves = std::pair<std::size_t, std::uint32_t>;
constexpr Leaves kNone{9, 9};

TEST_F(SliceRequestQueueTest, SendsPlanesInTurn) {
  ASSERT_TRUE(queue.replace(request_of({{v1::SAGITTAL, 3}, {v1::AXIAL, 5}, {v1::CORONAL, 4}}),
                            stacks, header));
  EXPECT_EQ(sent(), Leaves(0, 5));
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 6}, {v1::CORONAL, 4}, {v1::SAGITTAL, 3}}, 1),
                            stacks, header));
  EXPECT_EQ(sent(), Leaves(1, 4));
  EXPECT_EQ(sent(), Leaves(2, 3));
  EXPECT_EQ(sent(), Leaves(0, 6));
  EXPECT_EQ(sent(), kNone);
}

TEST_F(SliceRequestQueueTest, NewestRequestOfAPlaneReplacesTheOthers) {
  for (std::uint32_t index = 0; index < 10; ++index) {
    ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, index}}), stacks, header));
  }
  EXPECT_EQ(sent(), Leaves(0, 9));
  EXPECT_EQ(sent(), kNone);
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 1}}, 1), stacks, header));
  ASSERT_TRUE(
      queue.replace(request_of({}, 1), stacks, header));  // the viewer looked away meanwhile
  EXPECT_EQ(sent(), kNone);
}

TEST_F(SliceRequestQueueTest, DoesNotResendSlicesInFlight) {
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 5}}), stacks, header));
  const auto due = queue.take();
  ASSERT_TRUE(due);
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 5}}), stacks, header));  // while it is made
  EXPECT_FALSE(queue.waiting());
  queue.depart();
  ASSERT_TRUE(
      queue.replace(request_of({{v1::AXIAL, 5}}), stacks, header));  // while it is in transit
  EXPECT_EQ(sent(), kNone);
  // It arrived, and is requested again.
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 5}}, 1), stacks, header));
  EXPECT_EQ(sent(), Leaves(0, 5));
}

TEST_F(SliceRequestQueueTest, LimitsSlicesInPreparationAndInFlight) {
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 1}, {v1::CORONAL, 1}, {v1::SAGITTAL, 1}}),
                            stacks, header));
  ASSERT_TRUE(queue.take());
  EXPECT_FALSE(queue.take());
  queue.give_up();
  EXPECT_EQ(sent(), Leaves(1, 1));
  EXPECT_EQ(sent(), Leaves(2, 1));
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 2}, {v1::CORONAL, 2}}), stacks, header));
  EXPECT_EQ(sent(), Leaves(0, 2));
  EXPECT_EQ(sent(), kNone);
  ASSERT_TRUE(queue.replace(request_of({{v1::CORONAL, 2}}, 9), stacks,
                            header));  // a number that was never sent
  EXPECT_EQ(sent(), kNone);
  ASSERT_TRUE(queue.replace(request_of({{v1::CORONAL, 2}}, 3), stacks, header));
  EXPECT_EQ(sent(), Leaves(1, 2));
}

/// Adds a slice along a line.
v1::CurvedSlice& add_curved(v1::SliceRequest& request, std::uint32_t id) {
  v1::CurvedSlice& curved = *request.add_slices()->mutable_curved();
  curved.set_id(id);
  curved.set_columns(5);
  curved.set_rows(3);
  curved.add_points()->set_x(-2);
  curved.add_points()->set_x(2);
  curved.set_pixel(1);
  return curved;
}

TEST_F(SliceRequestQueueTest, SendsOneCurvedSliceBesideThePlanes) {
  auto request = request_of({{v1::AXIAL, 5}});
  add_curved(request, 7);
  ASSERT_TRUE(queue.replace(request, stacks, header));
  EXPECT_EQ(sent(), Leaves(0, 5));
  const auto due = queue.take();
  ASSERT_TRUE(due && due->curved);
  EXPECT_EQ(due->curved->id, 7u);
  EXPECT_EQ(due->samples(header), 15u);
  ASSERT_TRUE(queue.replace(request, stacks, header));  // while it is made
  EXPECT_FALSE(queue.waiting());
  queue.put_back();
  EXPECT_TRUE(queue.take());
  queue.depart();
  ASSERT_TRUE(queue.replace(request, stacks, header));  // while it is in transit
  EXPECT_FALSE(queue.waiting());
  request.mutable_slices(1)->mutable_curved()->set_angle(1);
  ASSERT_TRUE(queue.replace(request, stacks, header));
  EXPECT_TRUE(queue.waiting());
}

TEST_F(SliceRequestQueueTest, RefusesInvalidCurvedSlices) {
  const auto refused = [&](const auto& change) {
    auto request = request_of({});
    change(request, add_curved(request, 7));
    const auto replaced = queue.replace(request, stacks, header);
    return replaced ? std::string("nothing") : replaced.error().field;
  };
  EXPECT_EQ(refused([](auto&, auto&) {}), "nothing");
  EXPECT_EQ(refused([](auto&, auto& curved) { curved.set_id(0); }), "slices[0].curved.id");
  EXPECT_EQ(refused([](auto&, auto& curved) { curved.clear_points(); }), "slices[0].curved.points");
  EXPECT_EQ(refused([](auto&, auto& curved) { curved.set_columns(6); }),
            "slices[0].curved.columns");
  EXPECT_EQ(refused([](auto&, auto& curved) { curved.set_columns(0); }), "nothing")
      << "the whole curve";
  EXPECT_EQ(refused([](auto& request, auto&) { add_curved(request, 8); }), "slices[1].plane");
}

TEST_F(SliceRequestQueueTest, RequeuesReturnedSliceUnlessANewerIsRequested) {
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 5}}), stacks, header));
  ASSERT_TRUE(queue.take());
  queue.put_back();
  EXPECT_EQ(sent(), Leaves(0, 5));
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 6}}, 1), stacks, header));
  ASSERT_TRUE(queue.take());
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 7}}, 1), stacks, header));
  queue.put_back();
  EXPECT_EQ(sent(), Leaves(0, 7));
  EXPECT_EQ(sent(), kNone);
}

TEST(SliceStackMessage, ContainsTheWholeGeometry) {
  volume::Header header;
  header.size = {30, 20, 10};
  header.spacing = {1, 2, 3};
  for (const auto& stack : stacks_of(header)) {
    const v1::SliceStack message = to_proto(stack);
    EXPECT_EQ(message.columns(), stack.columns);
    EXPECT_EQ(message.rows(), stack.rows);
    EXPECT_EQ(message.slices(), stack.slices);
    const auto same = [](const v1::Vec3& sent, const auto& kept) {
      return sent.x() == kept[0] && sent.y() == kept[1] && sent.z() == kept[2];
    };
    EXPECT_TRUE(same(message.first(), stack.first));
    EXPECT_TRUE(same(message.right(), stack.right));
    EXPECT_TRUE(same(message.down(), stack.down));
    EXPECT_TRUE(same(message.next(), stack.next));
  }
}

TEST_F(SliceRequestQueueTest, DoesNotSendForgottenRequests) {
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 5}, {v1::CORONAL, 1}}), stacks, header));
  queue.forget();
  EXPECT_FALSE(queue.waiting());
  EXPECT_EQ(sent(), kNone);
}

TEST_F(SliceRequestQueueTest, RefusesInvalidRequestAndNamesTheField) {
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 9}}), stacks, header));
  const auto refused = [&](const v1::SliceRequest& message) {
    const auto taken = queue.replace(message, stacks, header);
    return taken ? std::string("taken") : taken.error().field;
  };
  EXPECT_EQ(refused(request_of({{v1::CORONAL, 0}, {v1::AXIAL, 10}})), "slices[1].index");
  EXPECT_EQ(refused(request_of({{v1::SAGITTAL, 0xffffffff}})), "slices[0].index");
  EXPECT_EQ(refused(request_of({{v1::ANATOMICAL_PLANE_UNSPECIFIED, 0}})), "slices[0].plane");
  EXPECT_EQ(refused(request_of({{static_cast<v1::AnatomicalPlane>(77), 0}})), "slices[0].plane");
  EXPECT_EQ(refused(request_of({{v1::AXIAL, 1}, {v1::AXIAL, 2}})), "slices[1].plane");
  EXPECT_EQ(sent(), Leaves(0, 9));
}

v1::SliceRequest oblique_request(std::uint32_t id, std::uint32_t columns = 4) {
  v1::SliceRequest message;
  auto& at = *message.add_slices();
  at.set_plane(v1::AXIAL);
  at.set_index(9999);
  v1::ObliqueSlice& oblique = *at.mutable_oblique();
  oblique.set_id(id);
  oblique.set_columns(columns);
  oblique.set_rows(3);
  oblique.mutable_right()->set_x(1);
  oblique.mutable_down()->set_z(-1);
  oblique.set_thickness(2);
  oblique.set_projection(v1::PROJECTION_MAXIMUM);
  return message;
}

TEST_F(SliceRequestQueueTest, TakesObliqueSlicesAndSendsEachOnce) {
  ASSERT_TRUE(queue.replace(oblique_request(1), stacks, header));
  ASSERT_TRUE(queue.replace(oblique_request(2), stacks, header)) << "a newer one replaces it";
  const auto due = queue.take();
  ASSERT_TRUE(due && due->oblique);
  EXPECT_EQ(due->index, 9999u);
  EXPECT_EQ(due->oblique->id, 2u);
  EXPECT_EQ(due->oblique->columns, 4u);
  EXPECT_EQ(due->oblique->right, (volume::Vector{1, 0, 0}));
  EXPECT_EQ(due->oblique->projection, volume::Projection::kMaximum);
  queue.depart();
  ASSERT_TRUE(queue.replace(oblique_request(2), stacks, header));
  EXPECT_FALSE(queue.waiting()) << "it is in transit";
  ASSERT_TRUE(queue.replace(request_of({{v1::AXIAL, 5}}), stacks, header));
  EXPECT_EQ(sent(), Leaves(0, 5)) << "the slice of the stack is another one";
}

TEST_F(SliceRequestQueueTest, RefusesInvalidObliqueSlicesAndNamesTheField) {
  const auto field = [&](const v1::SliceRequest& request) {
    const auto noted = queue.replace(request, stacks, header);
    return noted ? std::string() : noted.error().field;
  };
  EXPECT_EQ(field(oblique_request(0)), "slices[0].oblique.id");
  EXPECT_EQ(field(oblique_request(1, 0)), "slices[0].oblique.columns");
  EXPECT_EQ(field(oblique_request(1, 1u << 31)), "slices[0].oblique.columns");
  EXPECT_FALSE(queue.waiting());
}

}  // namespace
}  // namespace diaphane::render
