import type { Api } from "../api/client";
import { studyTicketSource } from "../api/ticket_source";
import type { Place } from "../live/place";
import { openBrowserSocket } from "../protocol/browser_socket";
import { cameraOf, withCamera, type Scene } from "../protocol/messages";
import { tab } from "../storage";
import { forgetView } from "../video/view_memory";
import type { ViewStep } from "./definition";
import type { DelayLine } from "./delay_line";
import { viewKey, type Participation } from "./participation";
import { randomView } from "./views";

/** Returns the scene from a random view of this participant. `purpose` is the step, or one of its trials. */
export function fromRandomView(scene: Scene, seed: number, purpose: string): Scene {
  const pose = cameraOf(scene);
  return pose ? withCamera(scene, randomView(seed, purpose, pose)) : scene;
}

/** Returns the place of one step's picture. The view is remembered until the step is answered. */
export function studyPlace(api: Api, participation: Participation, step: ViewStep, delay: DelayLine | null): Place {
  const { key: participant, joined } = participation;
  const key = viewKey(participant, step.id);
  const ticketSource = () =>
    studyTicketSource(api.studies, participant, step.id, (thrown) => participation.endIfOver(thrown));
  return {
    key,
    data_set_id: null,
    lookPictures: null,
    isVisit: false,
    savedMarks: null,
    loadTour: null,
    ticketSource,
    fileTicketSource: ticketSource, // not used, because participants can save nothing
    leave: () => {
      if (participation.isAnswered(step.id)) forgetView(tab, key);
    },
    ...(step.view?.start === "random" ? { firstScene: (scene) => fromRandomView(scene, joined.seed, step.id) } : {}),
    ...(delay ? { openSocket: delay.around(openBrowserSocket) } : {}),
  };
}
