// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Loads the page's script, packed by gzip, in less than a third of the bytes. Servers need no setting for it: it is
// unpacked here. Where a browser, a server or a site's rules do not allow that, the plain script is loaded.

(() => {
  // Who asks for the page before its script is there waits for what the script will say.
  let [fulfil, reject] = [];
  const ready = new Promise((...both) => ([fulfil, reject] = both));
  ready.catch(() => undefined);
  window.radtex = { ready };
  const add = (address, failed) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = () => window.radtex.ready.then(fulfil, reject);
    script.onerror = failed;
    document.head.append(script);
  };
  const plain = () => add("viewer.js", () => reject(new Error("viewer.js could not be loaded")));
  const packed = async () => {
    const response = await fetch("viewer.js.gz");
    if (!response.ok) throw new Error(response.statusText);
    const bytes = new Uint8Array(await response.arrayBuffer());
    const isPacked = bytes[0] === 0x1f && bytes[1] === 0x8b; // some servers have browsers unpack it
    const stream = new Blob([bytes]).stream();
    const text = await new Response(isPacked ? stream.pipeThrough(new DecompressionStream("gzip")) : stream).blob();
    add(URL.createObjectURL(new Blob([text], { type: "text/javascript" })), plain);
  };
  if (location.protocol !== "file:") packed().catch(plain);
  else plain();
})();
