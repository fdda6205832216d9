import { useEffect, useState } from "preact/hooks";
import type { Scene } from "../../../protocol/messages";
import { linkOf } from "../../../scene/scene_link";
import { lampTextures, patternOf, skyTextures, textureOf, type TextureFiles } from "../../../scene/textures";
import { t } from "../../../texts";
import type { ViewerSession } from "../../../video/viewer_session";
import { IncludeMarks, shownAnnotations } from "../../marks/include_marks";
import { CopyField } from "../../copy_field";
import { textureFiles } from "../settings/texture_files";

export interface LinkPartProps {
  readonly session: ViewerSession;
  readonly dataSetId: string;
}

/** A link that contains the whole scene, for people who may open the scan. */
export function LinkPart({ session, dataSetId }: LinkPartProps) {
  const text = t.take;
  const [message, setMessage] = useState("");
  const [withMarks, setWithMarks] = useState(false);
  const { url, complete } = useSceneLink(session, dataSetId, withMarks);
  if (url === null) return <p>{text.linkTooLarge}</p>;
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(url);
      setMessage(text.copied);
    } catch {
      setMessage(text.notCopied); // the browser forbids it, or the connection is not secure
    }
  };
  return (
    <div class="share-link">
      <p class="muted">{text.linkLead}</p>
      {complete ? null : <p>{text.linkWithoutPatterns}</p>}
      <IncludeMarks session={session} on={withMarks} change={setWithMarks} />
      <CopyField value={url} label={text.linkField} button={text.copy} onCopy={() => void copy()} />
      <p class="muted" role="status">
        {message}
      </p>
    </div>
  );
}

interface SceneLink {
  /** Empty at first, and null if the scene is too large for a link. */
  readonly url: string | null;
  /** Whether the link contains everything, or leaves out the user's own images. */
  readonly complete: boolean;
}

/** The link to the current scene. */
function useSceneLink(session: ViewerSession, dataSetId: string, withMarks: boolean): SceneLink {
  const scene = session.editor.scene.value;
  const [link, setLink] = useState<SceneLink>({ url: "", complete: true });
  useEffect(() => {
    let current = true;
    const make = async (made: Scene) => {
      const files = await textureFiles([...lampTextures, ...skyTextures]);
      const hash = await linkOf(made, files, withMarks ? shownAnnotations(session) : null);
      if (!current) return;
      // A scene with a second scan leads to both.
      const path = scene?.overlay ? location.pathname : `/view/${dataSetId}`;
      const url = hash === null ? null : `${location.origin}${path}${hash}`;
      setLink({ url, complete: !hasOwnTextures(made, files) });
    };
    const saved = session.editor.toSave();
    if (saved) void make(saved);
    return () => {
      current = false;
    };
  }, [session, scene, dataSetId, withMarks]);
  return link;
}

const hasOwnTextures = (scene: Scene, files: TextureFiles): boolean =>
  scene.lights.some((light) => {
    const file = textureOf(light);
    return file !== null && patternOf(files, file) === undefined;
  });
