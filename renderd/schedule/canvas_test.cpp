#include "renderd/schedule/canvas.h"

#include <gtest/gtest.h>

#include <cmath>

namespace diaphane::render {
namespace {

double pixels(Canvas canvas) { return double(canvas.width) * canvas.height; }

CanvasInput input(Canvas viewport, double seconds_for_full, bool moving = true) {
  CanvasInput q;
  q.viewport = viewport;
  q.seconds_per_pixel = seconds_for_full / pixels(viewport);
  q.moving = moving;
  return q;
}

TEST(MovingCanvas, EqualsTheViewportAtRest) {
  EXPECT_EQ(plan_canvas(input({1280, 720}, 10.0, false)), (Canvas{1280, 720}));
}

TEST(MovingCanvas, KeepsFullSizeOnAFastDevice) {
  EXPECT_EQ(plan_canvas(input({1280, 720}, 0.99 * kMovingSampleSeconds)), (Canvas{1280, 720}));
  EXPECT_EQ(plan_canvas(input({4096, 4096}, 0.001)), (Canvas{4096, 4096}));
}

TEST(MovingCanvas, SharedDeviceRendersSmallerImages) {
  for (const double full : {0.0005, 0.003, 0.01, 0.03, 0.2}) {
    for (const std::size_t sharing : {2, 4, 8, 16, 64}) {
      CanvasInput q = input({1280, 720}, full);
      q.seconds_first = 0.1 * full;
      const Canvas alone = plan_canvas(q);
      q.sharing = sharing;
      const Canvas shared = plan_canvas(q);
      const auto seconds = [&](Canvas c) {
        return q.seconds_first + q.seconds_per_pixel * pixels(c);
      };
      EXPECT_LE(pixels(shared), pixels(alone));
      EXPECT_GE(shared.width, 0.49 * alone.width) << "no smaller than that";
      const double all = double(sharing) * seconds(shared);
      const double allowed = std::max(kSharedSeconds, seconds(alone));
      if (shared.width > 0.51 * alone.width) EXPECT_LE(all, 1.01 * allowed) << full << sharing;
      if (double(sharing) * seconds(alone) <= kSharedSeconds) EXPECT_EQ(shared, alone);
    }
  }
}

TEST(MovingCanvas, MeetsTheTimeBudgetAndKeepsTheAspectRatio) {
  for (const Canvas viewport :
       {Canvas{512, 512}, Canvas{1280, 720}, Canvas{393, 852}, Canvas{1919, 1079}}) {
    for (const double full : {0.09, 0.15, 0.2, 0.5, 1.0, 3.0}) {
      const Canvas planned = plan_canvas(input(viewport, full));
      EXPECT_LT(pixels(planned), pixels(viewport));
      EXPECT_LE(full * pixels(planned) / pixels(viewport), kMovingSampleSeconds * 1.05) << full;
      EXPECT_EQ(planned.width % 2, 0U);
      EXPECT_EQ(planned.height % 2, 0U);
      const double shape = double(viewport.width) / viewport.height;
      EXPECT_NEAR(double(planned.width) / planned.height / shape, 1.0, 0.05);
    }
  }
}

TEST(MovingCanvas, IsAtLeastSixteenPixelsWide) {
  const Canvas planned = plan_canvas(input({4096, 16}, 1000));
  EXPECT_GE(planned.width, 16U);
  EXPECT_EQ(planned.height, 16U);
  EXPECT_EQ(plan_canvas(input({16, 16}, 1000)), (Canvas{16, 16}));
}

TEST(MovingCanvas, ProbesUnknownSpeedWithASmallImage) {
  CanvasInput q;
  q.viewport = {1920, 1080};
  q.moving = true;
  EXPECT_LE(pixels(plan_canvas(q)), kProbePixels);
  q.moving = false;
  EXPECT_EQ(plan_canvas(q), q.viewport);
}

TEST(MovingCanvas, KeepsTheSizeWhileTheCostFluctuates) {
  CanvasInput q = input({512, 512}, 0.3);
  q.current = plan_canvas(q);
  const Canvas first = q.current;
  for (const double noise : {1.1, 0.95, 1.15, 1.0, 1.2}) {
    q.seconds_per_pixel = 0.3 * noise / pixels(q.viewport);
    q.current = plan_canvas(q);
    EXPECT_EQ(q.current, first) << noise;
  }
}

TEST(MovingCanvas, SlowConnectionLimitsOnlyTheMovingSize) {
  CanvasInput input{.viewport = {1280, 720}, .seconds_per_pixel = 1e-9, .moving = true};
  EXPECT_EQ(plan_canvas(input), input.viewport);
  input.largest_moving = 0.5;
  EXPECT_EQ(plan_canvas(input), (Canvas{640, 360}));
  input.seconds_per_pixel = 1e-5;  // an even slower device
  EXPECT_LT(plan_canvas(input).width, 640U);
  input.moving = false;
  EXPECT_EQ(plan_canvas(input), input.viewport);
}

}  // namespace
}  // namespace diaphane::render
