import type { Area, Point } from "../input/flat";

export interface Rectangle extends Point, Area {}

/**
 * Returns where a picture is drawn in an area. The field of view is vertical, so pictures are fitted by height and
 * centred. With `fitsWindow`, a wider one is fitted by width, so that all of it is visible.
 */
export function pictureIn(area: Area, picture: Area, fitsWindow: boolean): Rectangle {
  const fitting = (picture.width * area.height) / picture.height;
  if (fitsWindow && fitting > 1.02 * area.width) {
    const height = (picture.height * area.width) / picture.width;
    return { x: 0, y: (area.height - height) / 2, width: area.width, height };
  }
  // The sides of a smaller frame are rounded to whole pixels, which does not change its shape.
  const width = Math.abs(fitting - area.width) < 0.02 * area.width ? area.width : fitting;
  return { x: (area.width - width) / 2, y: 0, width, height: area.height };
}
