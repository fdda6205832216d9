import type { Api } from "../api/client";
import { ownPlace } from "../live/place";
import { cameraOf, sceneFromJson, type Scene } from "../protocol/messages";
import { hasComfort, originalsOf, setComfort } from "../scene/comfort";
import { browserParts, StillShot, type ShotState } from "../video/still_shot";
import type { StudyPicture, View } from "./definition";

export interface TakingEvents {
  /** Called with the number of the picture that is rendered, from 1, and how much of it is done, from 0 to 1. */
  readonly progress: (number: number, done: number) => void;
  readonly taken: (picture: string, file: Blob) => Promise<void>;
}

export type TakingProblem = "picturesFailed" | "picturesNoComfort";
export interface Taking {
  /** Resolves with what went wrong, or null. */
  readonly done: Promise<TakingProblem | null>;
  readonly stop: () => void;
}

const side = 512;
/** The estimated relative error of a picture, which is denoised. */
const pictureError = 0.06;
const jpegQuality = 0.9;

/** Renders one view in the comforts of the pictures, as JPEG files without metadata. */
export function takePictures(api: Api, view: View, pictures: readonly StudyPicture[], events: TakingEvents): Taking {
  let shot: StillShot | null = null;
  let stopped = false;
  const run = async (): Promise<TakingProblem | null> => {
    const scene = sceneFromJson(JSON.stringify(view.scene));
    if (!scene || !cameraOf(scene)) return "picturesFailed";
    const originals = originalsOf([scene]);
    if (!hasComfort(scene, originals)) return "picturesNoComfort";
    for (const [i, { id, comfort }] of pictures.entries()) {
      if (stopped) return "picturesFailed";
      const coloured = setComfort(scene, originals, comfort);
      const file = await render(api, view.data_set_id, coloured, {
        begun: (one) => (shot = one),
        progress: (done) => events.progress(i + 1, done),
      });
      if (!file) return "picturesFailed";
      await events.taken(id, file);
    }
    return null;
  };
  return {
    done: run(),
    stop: () => {
      stopped = true;
      shot?.stop();
    },
  };
}

interface Rendering {
  readonly begun: (shot: StillShot) => void;
  readonly progress: (done: number) => void;
}

function render(api: Api, dataSetId: string, scene: Scene, { begun, progress }: Rendering): Promise<Blob | null> {
  const sheet = document.createElement("canvas");
  sheet.width = side;
  sheet.height = side;
  const context = sheet.getContext("2d", { alpha: false });
  let id: string | null = null;
  const place = ownPlace(api, dataSetId);
  return new Promise((resolve) => {
    const changed = (state: ShotState) => {
      if (state.kind === "rendering") {
        progress(state.done ?? 0);
        return;
      }
      place.leave(id);
      // A canvas writes no metadata: a picture of a body contains nothing else.
      if (state.kind === "done") sheet.toBlob(resolve, "image/jpeg", jpegQuality);
      else resolve(null);
    };
    const shot = new StillShot(
      { scene, size: { width: side, height: side }, error: pictureError },
      {
        draw: ({ image }) => context?.drawImage(image, 0, 0),
        drawTiles: (tiles) => {
          for (const { x, y, width, height, rgba } of tiles)
            context?.putImageData(new ImageData(rgba, width, height), x, y);
        },
      },
      browserParts(
        place.fileTicketSource((known) => (id = known)),
        [],
        changed,
      ),
    );
    begun(shot);
    shot.start();
  });
}
