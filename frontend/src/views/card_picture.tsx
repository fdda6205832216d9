import { t } from "../texts";
import { Icon } from "./icons";
import type { Picture } from "./thumbnail";

/** The picture of a ready scan on its card, or words that say why there is none. */
export function CardPicture({ picture, title }: { readonly picture: Picture; readonly title: string }) {
  const { url, missing } = picture;
  return (
    <div class={`card-picture${url === null && !missing ? " card-working" : ""}`}>
      {url !== null ? (
        <img src={url} alt={t.scans.picture(title)} width={320} height={320} />
      ) : (
        <p class="card-no-picture" role="status">
          <Icon name="clock" />
          {missing ? t.scans.noPicture : t.scans.pictureBeingMade}
        </p>
      )}
    </div>
  );
}
