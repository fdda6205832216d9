import type { Area } from "../../input/flat";
import { roleOf } from "../../live/role";
import { keyOf } from "../../marks/marks";
import { paintMarks, type PaintedMark } from "../../marks/paint";
import { viewOfPicture } from "../../marks/view";
import { pictureIn } from "../../video/picture_in";
import { eyeOf } from "../../picture/handles";
import type { ViewerSession } from "../../video/viewer_session";
import { numberOf } from "./picture_marks";

export type Decorate = (canvas: OffscreenCanvasRenderingContext2D, size: Area) => void;

/** Returns the marks that are drawn over the picture, those of the others first. */
export function marksInPicture({ marks, audience }: ViewerSession): readonly PaintedMark[] {
  const number = numberOf(roleOf(audience.value));
  const own = marks.shown.value ? marks.items.value : [];
  return [
    ...marks.othersList.value.map((one) => ({ mark: one.mark, key: keyOf(one.number, one.mark.id) })),
    ...own.map((mark) => ({ mark, key: keyOf(number, mark.id) })),
  ];
}

/**
 * Returns the size of a pixel of the page in a saved picture, so that lines and texts are as large
 * as on the screen.
 */
export const unitOf = (viewport: Area, size: Area): number =>
  Math.max(0.5, (size.height * devicePixelRatio) / viewport.height);

/**
 * Returns a function that draws the current marks, even if they change before the picture is
 * finished. With `asShown`, the marks fit a picture of the whole screen, where that of a follower
 * has borders.
 */
export function decorationOf(session: ViewerSession, asShown = false): Decorate {
  const marks = marksInPicture(session);
  const scene = session.editor.scene.value;
  const eye = scene && eyeOf(scene);
  const { follows, freeCamera } = roleOf(session.audience.value);
  const shown = session.pictures.picture.value;
  const hidden = session.marks.hidden.value;
  const viewport = session.viewport;
  return (canvas, size) => {
    if (!eye) return;
    const place = asShown && shown ? pictureIn(size, shown, follows && !freeCamera) : { x: 0, y: 0, ...size };
    const view = viewOfPicture(eye, place, hidden);
    paintMarks(canvas, marks, view, size, unitOf(viewport, size));
  };
}

/** Returns the picture with the marks. */
export async function decorated(png: Blob, decorate: Decorate): Promise<Blob> {
  const picture = await createImageBitmap(png);
  const sheet = new OffscreenCanvas(picture.width, picture.height);
  const canvas = sheet.getContext("2d", { alpha: false });
  canvas?.drawImage(picture, 0, 0);
  if (canvas) decorate(canvas, { width: picture.width, height: picture.height });
  picture.close();
  return sheet.convertToBlob({ type: "image/png" });
}
