import { useMemo, useState } from "preact/hooks";
import { guestPlace, newGuest, rememberedGuest } from "../live/place";
import { tab } from "../storage";
import { t } from "../texts";
import { AccountFrame } from "./account_frame";
import { Field } from "./field";
import { Shell } from "./shell";
import { useApp } from "./state";
import { Viewer } from "./viewer/viewer";

/**
 * The page that a link to a session opens. It asks for an optional name, then shows the picture. It
 * needs no account.
 */
export function Join({ token }: { readonly token: string }) {
  const app = useApp();
  const [guest, setGuest] = useState(() => rememberedGuest(tab, token));
  const [name, setName] = useState("");
  const place = useMemo(() => (guest ? guestPlace(app.api, token, guest) : null), [app, token, guest]);
  if (place) return <Viewer place={place} title={t.live.guestTitle} visitor={{ kind: "session" }} />;
  return (
    <Shell>
      <AccountFrame title={t.live.joinTitle} lead={t.live.joinLead}>
        <form
          noValidate
          onSubmit={(event) => {
            event.preventDefault();
            setGuest(newGuest(tab, token, name));
          }}
        >
          <Field
            label={t.live.name}
            value={name}
            onInput={setName}
            autocomplete="nickname"
            hint={t.live.nameHint}
            most={40}
          />
          <p class="muted">{t.sharing.views.toldGuest}</p>
          <button type="submit" class="button button-main">
            {t.live.join}
          </button>
        </form>
      </AccountFrame>
    </Shell>
  );
}
