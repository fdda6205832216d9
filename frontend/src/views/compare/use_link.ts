import { effect } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import type { Motion } from "../../compare/mapped_camera";
import { PictureLink, showSameRegion, type LinkMode } from "../../compare/picture_link";
import { tab } from "../../storage";
import type { ViewerSession } from "../../video/viewer_session";

const modeKey = "diaphane.compare.link";
export const linkModes: readonly LinkMode[] = ["off", "sides", "places"];

export interface LinkChoice {
  readonly mode: LinkMode;
  /** The modes that can be chosen. */
  readonly modes: readonly LinkMode[];
  readonly choose: (mode: LinkMode) => void;
}

const remembered = (): LinkMode | null => linkModes.find((one) => one === tab.getItem(modeKey)) ?? null;

/** Links two sessions once both show something. Scans that show the same region are linked by place if they are aligned. */
export function useLink(
  sessions: readonly [ViewerSession | null, ViewerSession | null],
  motion: Motion | null,
): LinkChoice {
  const [chosen, setChosen] = useState<LinkMode | null>(remembered);
  const [ready, setReady] = useState(false);
  const [link, setLink] = useState<PictureLink | null>(null);
  const [first, second] = sessions;
  useEffect(() => {
    if (!first || !second) return;
    const both = new PictureLink([first, second]);
    setLink(both);
    const stop = effect(() => setReady(first.editor.scene.value !== null && second.editor.scene.value !== null));
    return () => {
      stop();
      both.close();
    };
  }, [first, second]);
  const placed = ready && first && second && motion !== null && showSameRegion(first.editor, second.editor, motion);
  const wanted = chosen ?? (placed ? "places" : "sides");
  const mode = wanted === "places" && motion === null ? "sides" : wanted;
  useEffect(() => {
    if (ready) link?.link(mode, motion);
  }, [link, ready, mode, motion]);
  return {
    mode,
    modes: linkModes.filter((one) => one !== "places" || motion !== null),
    choose: (one) => {
      tab.setItem(modeKey, one);
      setChosen(one);
    },
  };
}
