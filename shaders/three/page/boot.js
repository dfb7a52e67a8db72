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
    // What is not our script, such as a web page that a server sends in its place, has put nothing there.
    script.onload = () => (window.radtex.ready === ready ? failed() : window.radtex.ready.then(fulfil, reject));
    script.onerror = failed;
    document.head.append(script);
  };
  const complain = () => {
    const headline = "viewer.js is missing or damaged";
    document.getElementById("headline").textContent = headline;
    document.getElementById("remedy").textContent = "Put all files of the export into one folder of the server, or export again. Browsers of many years ago cannot read it.";
    document.body.classList.remove("loading");
    document.body.classList.add("failed");
    reject(new Error(headline));
  };
  const plain = () => add("viewer.js", complain);
  const packed = async () => {
    const response = await fetch("viewer.js.gz");
    if (!response.ok) throw new Error(response.statusText);
    const bytes = new Uint8Array(await response.arrayBuffer());
    const isPacked = bytes[0] === 0x1f && bytes[1] === 0x8b; // some servers have browsers unpack it
    const stream = new Blob([bytes]).stream();
    const text = await new Response(isPacked ? stream.pipeThrough(new DecompressionStream("gzip")) : stream).blob();
    const isPage = (await text.slice(0, 64).text()).trimStart().startsWith("<"); // as servers of apps send for what they lack
    if (isPage) throw new Error("a web page came in the place of viewer.js.gz");
    add(URL.createObjectURL(new Blob([text], { type: "text/javascript" })), plain);
  };
  if (location.protocol !== "file:") packed().catch(plain);
  else plain();
})();
