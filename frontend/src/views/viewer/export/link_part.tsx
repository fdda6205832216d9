import { useEffect, useState } from "preact/hooks";
import { linkOf } from "../../../scene/scene_link";
import { hasTextures } from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { CopyField } from "../../copy_field";

export interface LinkPartProps {
  readonly session: ViewerSession;
  readonly dataSetId: string;
}

/** A link that contains the whole scene, for people who may open the scan. */
export function LinkPart({ session, dataSetId }: LinkPartProps) {
  const text = t.take;
  const [said, setSaid] = useState("");
  const scene = session.editor.scene.value;
  const url = useSceneLink(session, dataSetId);
  if (url === null) return <p>{text.linkTooLarge}</p>;
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(url);
      setSaid(text.copied);
    } catch {
      setSaid(text.notCopied); // the browser forbids it, or the connection is not secure
    }
  };
  return (
    <div class="share-link">
      <p class="muted">{text.linkLead}</p>
      {scene && hasTextures(scene) ? <p>{text.linkWithoutPatterns}</p> : null}
      <CopyField value={url} label={text.linkField} button={text.copy} onCopy={() => void copy()} />
      <p class="muted" role="status">
        {said}
      </p>
    </div>
  );
}

/** The link to the current scene. Empty at first, and null if the scene is too large for a link. */
function useSceneLink(session: ViewerSession, dataSetId: string): string | null {
  const scene = session.editor.scene.value;
  const [url, setUrl] = useState<string | null>("");
  useEffect(() => {
    let current = true;
    if (scene)
      void linkOf(scene).then((hash) => {
        if (current) setUrl(hash === null ? null : `${location.origin}/view/${dataSetId}${hash}`);
      });
    return () => {
      current = false;
    };
  }, [scene, dataSetId]);
  return url;
}
