// What is seen, in three sentences, for who opens the page for the first time; and how to drive with what is at hand.

const touch = matchMedia("(pointer: coarse)");
const NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"];

export const WHAT_PICTURES_ARE = "Each picture is the world as one program sees it; a pink line leads from where it shows a thing to where that really is.";

/** How an avatar is driven on this device, to follow "Drive an avatar:". */
export function howToDrive() {
  return touch.matches ? "touch a picture, and hold a finger where its avatar shall go" : "click a picture, then press WASD or the arrow keys";
}

export function howToDriveOn(slot) {
  return touch.matches
    ? `You drive avatar ${slot}. Hold a finger where it shall go.`
    : `You drive avatar ${slot} with WASD, the arrow keys, or the mouse button held where it shall go. Esc lets go.`;
}

export function intro(session) {
  const count = session.players().length;
  const watching = session.present().length - count;
  if (session.hello?.mode === "capture") return "This is the world that the peers agreed on, rebuilt from their packets alone. A thing has the colour of the peer that decides about it. Play it, or drag the slider.";
  if (session.present().length === 0) return "";
  const here = count + watching;
  if (session.waits()) return `${here === 1 ? "One program is" : `${capital(inWords(here))} programs are`} here, and ${here === 1 ? "it waits" : "they wait"} for more, as --wait-peers says. Nothing moves until all have come.`;
  const waits = count === 1 && !session.replayed() ? " It is alone: others may join, and with --wait-peers it waits for them." : "";
  const programs = (count === 1 ? "One program plays" : `${capital(inWords(count))} programs play`) + (watching > 0 ? `, and ${inWords(watching)} ${watching === 1 ? "watches" : "watch"},` : "");
  const was = session.replayed() ? "This is a recording: play it, or drag the slider." : session.drivable().length > 0 ? `Drive an avatar: ${howToDrive()}.` : session.offline ? "" : "This page may only look.";
  return `${programs} in one world without a server, and each picture is the world as one of them sees it. `
    + `A thing has the colour of the peer that decides about it; a pink line leads from where a picture shows it to where it really is. ${was}${waits}`;
}

function inWords(count) {
  return NUMBERS[count] ?? String(count);
}

function capital(word) {
  return word[0].toUpperCase() + word.slice(1);
}
